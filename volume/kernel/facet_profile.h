#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "phase/surface/microfacet.h"
#include "volume/quadrature/direction_sets.h"

namespace lamella {

/// The BSDF of facets that are the same about z, single scattering, for pairs of |mu| and the
/// azimuth x = pi - phi; volume/kernel/facet_modes.h turns it into azimuthal modes. Light comes
/// from the rarer side or from the denser one; the transmitted part is written for light that comes
/// from the rarer side, and the rest follows by reciprocity, f(w_i, w_o) / n_o^2 symmetric: so the
/// limits of integration, beyond which no facet sends w_i to w_o, are the same for both.
class FacetProfile {
 public:
  enum class Kind { reflection, transmission };
  /// Reflectance of a facet by the cosine of incidence.
  using Reflectance = std::function<double(double cosine)>;

  /// Reflection. critical: cosine of incidence at a facet below which it reflects totally, or 0.
  FacetProfile(const Facets& facets, Masking masking, Reflectance reflectance, double critical)
      : facets_(facets),
        masking_(masking),
        reflectance_(std::move(reflectance)),
        critical_(critical) {}
  /// Transmission from the rarer side to the denser; ratio: index there over index here, > 1.
  FacetProfile(const Facets& facets, Masking masking, double ratio);

  /// Modes 0 ... result.size() - 1 of f [1/sr] from |mu_i| to |mu_o|.
  void modes(double mu_i, double mu_o, Eigen::ArrayXd& result) const;

  /// Where f as a function of the other cosine is not smooth, or peaks: polar angles [radians] in
  /// (0, pi / 2), given mu_i (other: of w_o) or mu_o (other: of w_i).
  struct Places {
    std::vector<double> edges;
    double peak = 0;   ///< in [0, pi / 2]
    double width = 1;  ///< of the peak
  };
  [[nodiscard]] Places places(double mu, bool given_is_in) const;

 private:
  // Of one pair: h is the facet's normal times its length, |h_xy|^2 = gap + 4 product sin^2(x / 2).
  struct Pair {
    double hz, gap, product, end;    // no facet does it beyond x = end
    std::optional<double> critical;  // where the facet begins to transmit
  };
  [[nodiscard]] Pair pair_of(double mu_i, double mu_o) const;
  [[nodiscard]] double value(const Pair& pair, double mu_i, double mu_o, double x) const;

  Facets facets_;
  Masking masking_;
  Reflectance reflectance_;
  double critical_ = 0;
  double ratio_ = 0;  // 0: reflection
};

}  // namespace lamella
