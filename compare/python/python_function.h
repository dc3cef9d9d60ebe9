#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <string>

#include "analytic/model/model.h"

namespace lamella {

/// What is known of a Python function that is judged as a model: one lobe of no order in
/// particular, no parameters.
[[nodiscard]] ModelInfo function_info(const std::string& name, bool transmits);

/// f(w_i, w_o) [1/sr] by a Python function of two arrays of unit vectors, float64 [n, 3] each, that
/// gives n values, [n], [n, 1] (grey) or [n, 3]. It is called with many pairs at a time, from any
/// thread, the interpreter's lock held. What it raises comes out as it is
/// (pybind11::error_already_set); a result of another shape throws std::invalid_argument, a value
/// that is not finite or negative std::domain_error with the pair. Unless it `transmits` it is not
/// asked where the directions lie on different sides: 0.
[[nodiscard]] std::unique_ptr<Model> function_model(const std::string& name,
                                                    pybind11::object function, bool transmits);

/// Channels of what it gives, 1 or 3, found by a call with one pair.
[[nodiscard]] int channels_of_function(const std::string& name, const pybind11::object& function);

}  // namespace lamella
