#pragma once

#include <memory>
#include <vector>

#include "phase/interface/interfaces.h"
#include "phase/surface/surface_law.h"
#include "volume/adding/pile_operator.h"
#include "volume/kernel/facet_profile.h"

namespace lamella {

/// A rough boundary between two dielectrics, single scattering at facets that are the same about z:
/// modes of its order 0, by volume/kernel/facet_modes.h. Both media have indices of their own.
class RoughBoundary {
 public:
  /// Modes 0 ... modes - 1. Between two directions that are asked for nothing is counted:
  /// ClosedOrders has that.
  RoughBoundary(const Interface& interface, const DirectionSets& above, const DirectionSets& below,
                int modes);

  /// The same boundary turned upside down.
  [[nodiscard]] RoughBoundary turned() const;

  [[nodiscard]] PileOperator at(int mode) const;

 private:
  struct Side {
    std::vector<Eigen::MatrixXd> r, t;  // [mode]
    Eigen::RowVectorXd lost;
  };
  const DirectionSets *above_, *below_;
  Side from_above_, from_below_;
};

/// The share of light from w (w.z > 0) that facets reflect, wherever it goes then: the mean
/// reflectance of those it sees, by quadrature over their slopes.
[[nodiscard]] double met_by_facets(const Facets& facets,
                                   const FacetProfile::Reflectance& reflectance, Direction w);

/// An opaque surface with a law of its own, one channel of it: modes of its order 1. A conductor's
/// facets by volume/kernel/facet_modes.h; a mirror as beams; other laws, which are smooth, by
/// Gauss-Legendre quadrature in the azimuth at each pair.
class Ground {
 public:
  Ground(std::shared_ptr<const SurfaceLaw> law, int channel, const DirectionSets& sets, int modes);

  [[nodiscard]] PileOperator at(int mode) const;

 private:
  const DirectionSets* sets_;
  Eigen::VectorXd mirror_in_, mirror_out_;  // of a mirror
  std::vector<Eigen::MatrixXd> r_;          // [mode]
  Eigen::RowVectorXd absorbed_, lost_;
};

}  // namespace lamella
