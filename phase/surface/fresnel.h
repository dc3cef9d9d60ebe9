#pragma once

namespace lamella {

/// Fresnel's reflectance of unpolarised light at a smooth dielectric of relative index of
/// refraction ior > 0 (that beyond over that on this side); cosine of incidence in [0, 1].
[[nodiscard]] double fresnel_reflectance(double cosine, double ior);

/// Its mean over the hemisphere, 2 integral of F(mu) mu dmu: the reflectance for diffuse light from
/// outside. By quadrature, absolute error below 1e-8 for ior in [1.01, 4].
[[nodiscard]] double mean_fresnel_reflectance(double ior);

}  // namespace lamella
