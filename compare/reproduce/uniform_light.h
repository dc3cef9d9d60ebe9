#pragma once

#include <string>

#include "analytic/model/model.h"

namespace lamella {

/// The share of uniform light that leaves towards mu, by Gauss's rule of 16 points in the cosine
/// and 24 equal steps in the azimuth: for pictures, not for narrow lobes. Reciprocal models.
[[nodiscard]] Rgb quick_albedo(const Model& model, double mu);

/// Its cosine-weighted mean over the hemisphere (the Bond albedo), by Gauss's rule of 8 points.
[[nodiscard]] Rgb quick_average_albedo(const Model& model);

/// The model's request with the albedo, per channel, at which it reflects `color` of uniform light
/// within 1e-3, or albedo 1 where it cannot: halving, as the reflectance grows with the albedo.
/// `request`: the model and its other parameters.
[[nodiscard]] std::string with_bond_albedo(const std::string& request, Rgb color);

}  // namespace lamella
