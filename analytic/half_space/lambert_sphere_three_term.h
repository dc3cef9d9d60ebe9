#pragma once

#include "analytic/model/model.h"

namespace lamella {

/// Half space of Lambertian spheres, albedo c: the exact solution for the first three Legendre
/// terms of their phase function (three_term.h), its order 1 replaced by exact single scattering.
/// Lobes `single` and `multiple`. Reciprocal. Relative error below 0.002 for cosines from 0.01;
/// directional albedo at c = 1: 1 within 1.2e-4.
/// Horak and Chandrasekhar 1961, as in d'Eon 2021, section 3, with exact H functions and constants.
[[nodiscard]] ModelInfo lambert_sphere_three_term_model();

/// The exact three-term solution with its own order 1: off by 13 % at grazing for c = 0.9, and by
/// up to 45 % in the dark forward directions of c = 0.3.
[[nodiscard]] ModelInfo lambert_sphere_three_term_pure_model();

}  // namespace lamella
