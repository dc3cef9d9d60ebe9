#pragma once

#include "analytic/model/model.h"
#include "analytic/rough_surface/oren_nayar_formula.h"

namespace lamella {

// Rough diffuse surfaces of Lambertian V-cavities after Oren and Nayar 1994, "Generalization of
// Lambert's reflectance model". rho: albedo of the facets; sigma: standard deviation of their slope
// angle [rad]. Portsmouth, Kutz and Hill 2025, "EON", section 2, for the notation s and t:
//   s = sin theta_i sin theta_o cos phi, phi = 0 on the side of the light.
// All reciprocal. Where both cosines vanish, the values diverge.

/// The full model: single scattering with the terms C1, C2, C3, and double scattering.
/// alpha = max(theta_i, theta_o), beta = min(theta_i, theta_o), x = cos phi:
///   f = rho / pi (C1 + x C2 tan beta + (1 - |x|) C3 tan((alpha + beta) / 2))
///     + 0.17 rho^2 / pi sigma^2 / (sigma^2 + 0.13) (1 - x (2 beta / pi)^2)
///   C1 = 1 - 0.5 sigma^2 / (sigma^2 + 0.33), C = sigma^2 / (sigma^2 + 0.09),
///   C2 = 0.45 C (sin alpha - [x < 0] (2 beta / pi)^3), C3 = C / 8 (4 alpha beta / pi^2)^2
/// Lobes `single` and `double`: orders 1 and 2. As published it is negative in some forward pairs
/// near grazing.
[[nodiscard]] ModelInfo oren_nayar_full_model();

/// The "qualitative" model: f = rho / pi (A + B s+ / max(mu_i, mu_o)),
///   A = 1 - 0.5 sigma^2 / (sigma^2 + 0.33), B = 0.45 sigma^2 / (sigma^2 + 0.09) (EON eqs. 1-4).
[[nodiscard]] ModelInfo oren_nayar_model();

/// The qualitative model with 0.57 for 0.33: the footnote of the paper, for the missing
/// interreflections.
[[nodiscard]] ModelInfo oren_nayar_footnote_model();

/// Fujii's fit to the full model: f = rho / pi (A' + B s / t), t = max(mu_i, mu_o) for s > 0 and 1
/// otherwise, A' = A + 0.17 rho sigma^2 / (sigma^2 + 0.13).
/// Fujii 2013, "A tiny improvement of Oren-Nayar reflectance model".
[[nodiscard]] ModelInfo fujii_qualitative_model();

/// The integral over the hemisphere of oren_nayar_term times a cosine, as a function of the other
/// cosine, in [0, 1] (EON eq. 8, its tan theta (1 - sin^3 theta) written without 0 * infinity):
///   G_q = sin (theta - sin cos) + 2/3 sin cos (1 + sin + sin^2) / (1 + sin).
[[nodiscard]] double oren_nayar_integral(double mu);
/// The same integral of fujii_term: G_F = G_q - 2/3 sin theta (eq. 13).
[[nodiscard]] double fujii_integral(double mu);

/// Mean over the hemisphere, cosine-weighted, of G_q / pi: 2/3 - 64 / (45 pi) (eq. 9), and of
/// G_F / pi: 2/3 - 28 / (15 pi) (eq. 15).
inline constexpr double kOrenNayarMean = 2.0 / 3 - 64 / (45 * kPi);
inline constexpr double kFujiiMean = 2.0 / 3 - 28 / (15 * kPi);

}  // namespace lamella
