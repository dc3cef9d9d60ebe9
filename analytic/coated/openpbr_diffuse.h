#pragma once

#include "analytic/model/model.h"

namespace lamella {

/// The glossy-diffuse slab of the OpenPBR Surface specification, a dielectric over EON:
///   f = specular_color f_diel + (1 - E(mu_o)) f_EON   (layering = albedo_scaling),
/// or with (1 - E(mu_i)) (1 - E(mu_o)) / (1 - <E>), the specification's reciprocal alternative.
/// EON's albedo is base_weight base_color. f_diel: GGX in single scattering, alpha =
/// specular_roughness^2, of index (1 + e) / (1 - e), e = sqrt(specular_weight) (ior - 1) / (ior +
/// 1), so that specular_weight scales the reflectance at normal incidence (kept below 1). E is the
/// directional albedo of the untinted reflection. The specification leaves open whether f_diel has
/// multiple scattering; here it has none (the light that it loses is missing from E and goes to the
/// base). Lobes `coat` and `base`. The specification's rho_ms of EON has a second 1 / pi, which is
/// left out: with it white EON loses energy.
[[nodiscard]] ModelInfo openpbr_diffuse_model();

}  // namespace lamella
