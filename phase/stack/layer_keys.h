#pragma once

#include "phase/parameters/parameters.h"

namespace lamella {

/// Keys of a layer beside those of its medium: albedo, thickness [mm], density [1/mm]. The albedo
/// is also that of a Lambertian substrate.
[[nodiscard]] const ParameterInfo& albedo_key();
[[nodiscard]] const ParameterInfo& thickness_key();
[[nodiscard]] const ParameterInfo& density_key();

}  // namespace lamella
