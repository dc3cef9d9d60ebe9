#pragma once

#include "analytic/model/model.h"

namespace lamella {

/// Cloth whose facets stand up: f = color D G / (4 mu_i mu_o), G = 1 / (1 + Lambda_i + Lambda_o),
///   D(m) = (2 + 1 / r) sin(theta_m)^(1 / r) / (2 pi), the integral of D cos is 1.
/// Conty and Kulla 2017, "Production friendly microfacet sheen BRDF". Lambda is their fit to the
/// Smith term of D, see sheen_lambda. Reciprocal. Their softened terminator is left out: it holds
/// for the light's direction alone. r in [0.1, 1]: below 0.06 the fit makes energy at grazing (up
/// to 8 times what arrives at r = 0.001). Lobe `sheen`.
[[nodiscard]] ModelInfo sheen_conty_kulla_model();

/// D(m) [1/sr] from the cosine and sine of the normal; r in (0, 1].
[[nodiscard]] double sheen_density(double sine, double roughness);

/// mu Lambda(mu), mu in (0, 1]: Lambda = exp(L(mu)) for mu < 1/2, exp(2 L(1/2) - L(1 - mu)) above,
///   L(x) = a / (1 + b x^c) + d x + e,
/// a to e those of r = 0 and r = 1 interpolated by (1 - r)^2. The fit stays finite where the exact
/// term grows like 1 / mu: below mu = 1e-3 mu Lambda stays as it is there.
[[nodiscard]] double sheen_masking(double mu, double roughness);

}  // namespace lamella
