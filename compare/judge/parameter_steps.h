#pragma once

#include "phase/parameters/parameters.h"

namespace lamella {

/// Whether the parameter is the colour of what scatters or reflects: 1 stands for a white model, in
/// which only the form can lose or gain light.
[[nodiscard]] bool is_white(const ParameterInfo& p);

/// Whether the parameter is a shape that a sweep over its range should change: a number whose range
/// is not wider than 100 (wider are walks, seeds, factors without a scale), no index of refraction,
/// no key that stands for another by default (`_y`), none of a surface below (`bulk_`).
[[nodiscard]] bool is_shape(const ParameterInfo& p);

/// `steps` values from one end of a shape's range to the other, both ends among them; an end that
/// is not allowed is replaced by a value 1e-3 of the range inside.
[[nodiscard]] std::vector<double> steps_of_range(const ParameterInfo& p, int steps);

}  // namespace lamella
