#pragma once

#include "phase/surface/microfacet.h"
#include "phase/surface/surface_law.h"

namespace lamella {

/// A conductor: Fresnel reflection at a smooth surface or at the facets of a rough one, in single
/// scattering (which loses the light that facets hide) or with every reflection between facets.
class Conductor : public SurfaceLaw {
 public:
  /// facets: shape smooth, or rough; eta + i k: the complex index relative to the medium on the
  /// surface, per channel, eta > 0, k >= 0. white: reflects everything, whatever the index.
  struct Setting {
    Facets facets{};
    Masking masking = Masking::beta;
    bool multiple = false;
    Rgb eta{1}, k{0};
    bool white = false;
    friend bool operator==(const Setting&, const Setting&) = default;
  };

  explicit Conductor(const Setting& setting) : setting_(setting) {}

  /// Fresnel's reflectance per channel, cosine of incidence in [0, 1].
  [[nodiscard]] Rgb reflectance(double cosine) const;
  /// f of single scattering [1/sr]; one cosine may be 0, taken as its limit.
  [[nodiscard]] Rgb single(Direction wi, Direction wo) const;
  /// The density [1/sr] of sample() in single scattering; samples below the surface are missing.
  [[nodiscard]] double single_density(Direction wi, Direction wo) const;

  [[nodiscard]] Rgb eval(Direction wi, Direction wo, RandomStream& stream) const override;
  [[nodiscard]] std::optional<Sample> sample(Direction wi, RandomStream& stream) const override;
  /// Of one reflection, whatever comes after it.
  [[nodiscard]] double density(Direction wi, Direction wo) const override {
    return single_density(wi, wo);
  }
  [[nodiscard]] bool is_delta() const override {
    return setting_.facets.shape == FacetShape::smooth;
  }
  [[nodiscard]] bool is_stochastic() const override { return !is_delta() && setting_.multiple; }
  [[nodiscard]] bool is_symmetric_about_z() const override {
    return is_delta() || setting_.facets.alpha_x == setting_.facets.alpha_y;
  }
  [[nodiscard]] const Setting& setting() const { return setting_; }

 private:
  [[nodiscard]] Rgb multiple_estimate(Direction wi, Direction wo, RandomStream& stream) const;
  [[nodiscard]] Sample sample_multiple(Direction wi, RandomStream& stream) const;

  Setting setting_;
};

}  // namespace lamella
