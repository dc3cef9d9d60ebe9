#pragma once

#include <memory>

#include "analytic/coated/coat.h"
#include "analytic/model/model.h"

namespace lamella {

/// How a coat is put over a base: the factor of the base's lobe f_b. E: the directional albedo of
/// the interface's reflection, <E> its mean, A = color^((1 / mu_i' + 1 / mu_o') / 2) the coat's
/// absorption with refracted cosines, rho and E_b the base's mean albedo, n the coat's index.
enum class Layering {
  /// A (1 - E(mu_o)): OpenPBR's. Not reciprocal: white bases keep the energy of light that leaves
  /// along w_o; of light from a grazing w_i up to twice as much leaves as arrives.
  albedo_scaling,
  /// A (1 - E(mu_i)) (1 - E(mu_o)) / (1 - <E>): reciprocal; over white Lambert nothing is lost
  albedo_scaling_reciprocal,
  /// A (1 - E(mu_o)) Delta, OpenPBR's coat darkening: Delta = (1 - K) / (1 - E_b K), K between
  /// F(mu_o) (r_b = 0) and 1 - (1 - <F>) / n^2 (r_b = 1), F of a smooth coat, r_b the base's
  /// roughness: sqrt(alpha) of microfacet, 1 of all others
  darkened,
  /// T(mu_i) T(mu_o) / (n^2 (1 - rho K)), f_b between the directions in the coat: exact over
  /// Lambert for a smooth interface, with an absorbing coat too (Saunderson 1942), and for a rough
  /// one whose rays scatter once. T: the share of light that arrives at the base; K: the share of
  /// Lambertian light from the base that comes back to it. Other bases: the bounces between are
  /// those of Lambert's law.
  saunderson,
  /// A (1 - E(mu_i)) (1 - E(mu_o)): Wolff 1994, "Diffuse-reflectance model for smooth dielectric
  /// surfaces"; light that the interface reflects back to the base is taken as part of the base's
  /// albedo, as in that paper
  wolff
};

/// A dielectric interface over any closed form here: f = tint f_c + factor f_b, f_c the reflection
/// of a rough interface in single scattering (none where the interface is smooth: its delta is
/// specular(w_i)).
struct CoatedSetting {
  Dielectric interface;  ///< air above; below: the coat's index
  Rgb color{1};          ///< share that two passes through the coat along the normal leave
  Rgb tint{1};           ///< factor of the coat's lobe
  Layering layering = Layering::albedo_scaling;
  double base_roughness = 1;  ///< r_b
  std::shared_ptr<const Model> base;
};

/// The model: lobes `coat` and `base`. Only reflection from above.
[[nodiscard]] std::unique_ptr<Model> make_coated(const CoatedSetting& setting);

/// The closed form `coated`: keys of the coat, `base` and the base's own keys behind a dot.
/// `models`: those that may lie below, but for the ones that are built from a stack.
[[nodiscard]] ModelInfo coated_model(const std::vector<ModelInfo>& models);

/// The interface by the keys that coats have in common; below kLeastRoughness it is smooth.
[[nodiscard]] Dielectric coat_interface(FacetShape shape, double alpha, double ior);

}  // namespace lamella
