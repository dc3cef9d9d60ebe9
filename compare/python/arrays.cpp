#include "compare/python/arrays.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace lamella {

namespace py = pybind11;

std::vector<Direction> directions_of(const Doubles1& array, const char* what) {
  if (array.ndim() != 2 || array.shape(1) != 3)
    throw std::invalid_argument(
        fmt::format("{}: found an array of {} axes; allowed: unit vectors, shape (..., 3)", what,
                    array.ndim()));
  const auto numbers = array.unchecked<2>();
  std::vector<Direction> directions;
  directions.reserve(static_cast<std::size_t>(numbers.shape(0)));
  for (py::ssize_t k = 0; k < numbers.shape(0); ++k) {
    const Direction w{numbers(k, 0), numbers(k, 1), numbers(k, 2)};
    if (!(std::abs(length(w) - 1) <= 1e-6))
      throw std::invalid_argument(
          fmt::format("{}: found [{}, {}, {}] in row {}, of length {:.9g}; allowed: unit vectors",
                      what, w.x, w.y, w.z, k, length(w)));
    directions.push_back(w);
  }
  return directions;
}

py::array_t<double> array_of(std::span<const Rgb> colors, int channels) {
  py::array_t<double> array(
      {static_cast<py::ssize_t>(colors.size()), static_cast<py::ssize_t>(channels)});
  auto numbers = array.mutable_unchecked<2>();
  for (std::size_t k = 0; k < colors.size(); ++k)
    for (int c = 0; c < channels; ++c) numbers(static_cast<py::ssize_t>(k), c) = colors[k][c];
  return array;
}

py::array_t<double> array_of(std::span<const Direction> directions) {
  py::array_t<double> array({static_cast<py::ssize_t>(directions.size()), py::ssize_t{3}});
  auto numbers = array.mutable_unchecked<2>();
  for (std::size_t n = 0; n < directions.size(); ++n) {
    const auto k = static_cast<py::ssize_t>(n);
    numbers(k, 0) = directions[n].x;
    numbers(k, 1) = directions[n].y;
    numbers(k, 2) = directions[n].z;
  }
  return array;
}

py::array view_of(std::span<const double> numbers, std::vector<py::ssize_t> shape,
                  std::vector<py::ssize_t> strides, py::handle owner) {
  for (py::ssize_t& stride : strides) stride *= static_cast<py::ssize_t>(sizeof(double));
  py::array view(py::dtype::of<double>(), std::move(shape), std::move(strides), numbers.data(),
                 owner);
  view.attr("setflags")(py::arg("write") = false);
  return view;
}

}  // namespace lamella
