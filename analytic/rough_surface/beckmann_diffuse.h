#pragma once

#include "analytic/model/model.h"

namespace lamella {

// A height field with Beckmann's distribution of slopes and Lambertian facets, under Smith's
// assumption that heights and slopes at different points are independent. It is the half space of
// one-sided Lambertian flakes whose normals have
//   D(m) = exp(-tan^2 / alpha^2) / (pi alpha^2 cos^4), integral of D cos = 1,
// in which light walks until it leaves (Heitz, Hanika, d'Eon and Dachsbacher 2016,
// "Multiple-scattering microfacet BSDFs with the Smith model"). Heitz and Dupuy 2015,
// "Implementing a simple anisotropic rough diffuse material with stochastic evaluation". alpha:
// roughness, root of twice the variance of a slope, in [0, 10].

/// Stochastic: f is the mean over `walks` random walks from w_i, each event's light towards w_o
/// counted with its expected attenuation over the event's depth, which leaves the variance bounded
/// down to mu = 0 on either side. The walks of one w_i are the same for every w_o, so that f is
/// smooth in w_o. Reciprocal in expectation; the energy of white facets is 1. alpha = 0 is Lambert.
/// Lobes `f1`, `f2`, `f3`, `fm`: orders 1, 2, 3 and 4+.
[[nodiscard]] ModelInfo beckmann_diffuse_model();

/// Projected area of the facets that face w [per area of the surface], w any unit vector:
///   sigma(w) = mu erfc(-x) / 2 + alpha s exp(-x^2) / (2 sqrt(pi)), x = mu / (alpha s),
/// s the sine; (1 + Lambda(w)) mu from above. Relative error below 1e-12 for mu >= 0, absolute
/// error below 1e-15 else.
[[nodiscard]] double beckmann_projected_area(Direction w, double alpha);

/// A normal with density D(m) <w, m> / sigma(w) [1/sr] from two uniforms in (0, 1). w: unit, of
/// positive projected area. The slope along w is found by Newton's method to 1e-12.
[[nodiscard]] Direction beckmann_visible_normal(Direction w, double alpha, double u1, double u2);

}  // namespace lamella
