#pragma once

#include "analytic/model/clipped_cosine.h"
#include "analytic/model/model.h"
#include "analytic/rough_surface/eon_formula.h"

namespace lamella {

// Portsmouth, Kutz and Hill 2025, "EON: A practical energy-preserving rough diffuse BRDF"; equation
// numbers are theirs. rho: albedo of the facets, r: roughness in [0, 1]. s / t is fujii_term of
// analytic/rough_surface/oren_nayar.h. All reciprocal.

/// Fujii's energy-conserving model: f = rho / pi (A + B s / t), A = 1 / (1 + (1/2 - 2 / (3 pi)) r),
/// B = r A (eqs. 10, 11).
[[nodiscard]] ModelInfo fon_model();

/// FON and the energy it loses (eq. 16). Lobes `ss`, FON itself, and `ms`:
///   rho^2 / pi <E> / (1 - rho (1 - <E>)) (1 - E(mu_i)) (1 - E(mu_o)) / (1 - <E>)
/// with E, <E> FON's directional and average albedo at rho = 1 (eq. 19). Directional albedo in
/// closed form, 1 within 1e-15 at rho = 1.
[[nodiscard]] ModelInfo eon_model();

/// EON with the fit of eq. 14 for E, clamped at 1: white albedo 0.9994 to 1.0002.
[[nodiscard]] ModelInfo eon_approx_model();

/// Directional albedo of FON at rho = 1 (eqs. 12, 13), 1 - A r fon_loss(mu); mu in [0, 1]. Relative
/// error below 2e-16.
[[nodiscard]] double fon_albedo(double mu, double roughness);
/// Its fit, eq. 14: absolute error below 6.1e-4 r; above 1 by up to 3.6e-4.
[[nodiscard]] double fon_albedo_fit(double mu, double roughness);
/// Average albedo of FON at rho = 1 (eq. 15).
[[nodiscard]] double fon_average_albedo(double roughness);

/// The lobe from which EON draws w_i given w_o, whose cosine is mu in [0, 1]; independent of rho.
/// Section 3.1; a, b, c, d are the fit of its listing 2. Samplers: see HemisphereSampler.
[[nodiscard]] ClippedCosine eon_sampling_lobe(double mu, double roughness);

}  // namespace lamella
