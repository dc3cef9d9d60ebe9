#pragma once

#include "analytic/model/model.h"

namespace lamella {

/// Facets of GGX or Beckmann, conductors or dielectrics, in single scattering:
///   reflection    f = F D G_2 / (4 mu_i mu_o),
///   transmission  f = (1 - F) D G_2 |w_i . m| |w_o . m| n^2 / (|mu_i| |mu_o| (w_i . m + n w_o .
///   m)^2)
/// with n = n_o / n_i (Walter et al. 2007, "Microfacet models for refraction through rough
/// surfaces", eqs. 20 and 21; phase/surface/microfacet.h for D and G_2, `masking`). f is the
/// radiance that leaves over the irradiance that arrives: f(w_i, w_o) / n_o^2 = f(w_o, w_i) /
/// n_i^2. `compensation` makes up for the light that single scattering loses. E is the share of
/// white light that is not lost, l = 1 - E, L its mean 2 integral of l mu dmu, F_avg that of F:
///
/// kulla_conty: a diffuse lobe, Kulla and Conty 2017, "Revisiting physically based shading at
/// Imageworks", with the square of F_avg that Hill 2018 has ("A multi-faceted exploration"):
///   f_m = l(mu_i) l(mu_o) / (pi L) F_avg^2 (1 - L) / (1 - F_avg L).
/// Dielectrics: l(mu_i) goes to the two sides in shares a and 1 - a, with l and L of the side of
/// w_o: f_m = a l l / (pi L). 1 - a = min(1, L' / L) (1 - F_avg), L' that of the other side: among
/// the reciprocal splits the one that follows F_avg as far as it can.
///
/// turquin: f_m = f F_0 (1 / E(mu_o) - 1), F_0 the reflectance at normal incidence; dielectrics:
/// f_m = f (1 / E(mu_o) - 1). Turquin 2019, "Practical multiple scattering compensation for
/// microfacet models". Not reciprocal: white facets keep the energy of light that leaves along w_o,
/// not that of light from w_i.
///
/// Lobes `single` and `multiple`. Sampled by visible normals and, for kulla_conty, the cosine law.
/// l is tabulated when the model is made; two roughnesses take no compensation.
[[nodiscard]] ModelInfo microfacet_model();

}  // namespace lamella
