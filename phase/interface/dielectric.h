#pragma once

#include "phase/random/random.h"
#include "phase/surface/fresnel_formulas.h"
#include "phase/surface/microfacet.h"
#include "phase/surface/smith_walk.h"

namespace lamella {

/// A boundary between two dielectrics with the normal z: unpolarised Fresnel reflection and
/// refraction, smooth or at the facets of a rough surface. Directions are unit and point away from
/// the boundary; f is the radiance that leaves over the irradiance that arrives [1/sr], so
/// f(w_i, w_o) / n_o^2 = f(w_o, w_i) / n_i^2, n the index on the side of each direction. Energies
/// carry no index.
struct Dielectric {
  Facets facets{};                  ///< facets.shape smooth: their other numbers have no meaning
  Masking masking = Masking::beta;  ///< of single scattering
  bool multiple = false;            ///< light scatters on between the facets (Smith's model)
  double above = 1, below = 1;      ///< indices of refraction, in [0.1, 10]

  struct Scattered {
    Direction wo;
    double kept;  ///< in [0, 1]; the rest is lost: the facets' own shadow, or the wrong side
  };

  [[nodiscard]] bool is_smooth() const { return facets.shape == FacetShape::smooth; }
  /// Index beyond the boundary over that on the side of w.
  [[nodiscard]] double ratio(Direction w) const { return w.z > 0 ? below / above : above / below; }
  /// Index on the side of w.
  [[nodiscard]] double index(Direction w) const { return w.z > 0 ? above : below; }

  /// Smooth: reflectance and refracted cosine of light from w.
  [[nodiscard]] Refraction<double> smooth_refraction(Direction w) const {
    return refraction(std::abs(w.z), ratio(w));
  }
  /// Smooth: the direction along which light from w goes on, refracted with that cosine > 0.
  [[nodiscard]] Direction smooth_refracted(Direction w, double cosine) const;

  /// f(w_i, w_o) of a rough surface's single scattering: reflection where mu_i mu_o > 0.
  /// Walter et al. 2007, eqs. 20 and 21. One cosine may be 0, taken as its limit.
  [[nodiscard]] double single(Direction wi, Direction wo) const;
  /// The density [1/sr] with which scatter(w_i) gives w_o in single scattering; its `kept` is then
  /// G_2 / G_1(w_i). The integral over w_o falls short of 1 by the share of samples on the wrong
  /// side.
  [[nodiscard]] double single_density(Direction wi, Direction wo) const;

  /// f(w_i, w_o): single(w_i, w_o), or of `multiple` an estimate whose mean is f.
  [[nodiscard]] double eval(Direction wi, Direction wo, RandomStream& stream) const {
    return multiple ? multiple_estimate(wi, wo, stream) : single(wi, wo);
  }

  /// One ray of light from w_i, reflected or refracted with Fresnel's probabilities.
  [[nodiscard]] Scattered scatter(Direction wi, RandomStream& stream) const;

  /// The direction of light from w_i that is refracted. `kept` is its share of the light: it
  /// contains Fresnel's transmittance, except in multiple scattering, where chance decides.
  [[nodiscard]] Scattered enter(Direction wi, RandomStream& stream) const;

  friend bool operator==(const Dielectric&, const Dielectric&) = default;

 private:
  [[nodiscard]] bool bounces_out(SmithRay& ray, RandomStream& stream) const;
  [[nodiscard]] Scattered scatter_single(Direction wi, RandomStream& stream) const;
  [[nodiscard]] Scattered scatter_multiple(Direction wi, RandomStream& stream) const;
  [[nodiscard]] double multiple_estimate(Direction wi, Direction wo, RandomStream& stream) const;
};

}  // namespace lamella
