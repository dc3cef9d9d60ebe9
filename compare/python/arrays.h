#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <span>
#include <vector>

#include "phase/math/color.h"
#include "phase/math/direction.h"

namespace lamella {

/// float64, C order: what the package's Python files hand down.
using Doubles1 = pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>;

/// Unit vectors of an array [n, 3]. Throws std::invalid_argument, naming `what` and the row, where
/// one is not finite or its length is not 1 within 1e-6 (float32 is).
[[nodiscard]] std::vector<Direction> directions_of(const Doubles1& array, const char* what);

/// Colours as an array [n, channels]: the first channel, or all three.
[[nodiscard]] pybind11::array_t<double> array_of(std::span<const Rgb> colors, int channels);

/// Unit vectors as an array [n, 3].
[[nodiscard]] pybind11::array_t<double> array_of(std::span<const Direction> directions);

/// An array that looks at numbers that `owner` keeps alive, read only. `strides`: in numbers.
[[nodiscard]] pybind11::array view_of(std::span<const double> numbers,
                                      std::vector<pybind11::ssize_t> shape,
                                      std::vector<pybind11::ssize_t> strides,
                                      pybind11::handle owner);

}  // namespace lamella
