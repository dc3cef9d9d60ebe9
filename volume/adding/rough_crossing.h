#pragma once

#include <Eigen/Core>
#include <vector>

#include "phase/stack/stack.h"
#include "volume/kernel/facet_profile.h"

namespace lamella {

/// Light that crosses two rough boundaries and the layers between them with no other event, at
/// pairs of directions that are asked for. Both lobes of transmission are narrow about the normal,
/// where the nodes lie furthest apart: a sum over nodes keeps of either lobe only its projection,
/// and loses the product of what both have beyond (6e-2 at 24 nodes for facets of alpha 0.4, along
/// the normal). Here the integral over the direction in between is taken with points of its own,
///   f_m = 2 pi integral of f2_m(mu', mu_o) exp(-depth sigma / mu') f1_m(mu_i, mu') mu' dmu'.
class RoughCrossing {
 public:
  /// upper, lower: rough, single scattering. above, between, below: the sets of their media.
  /// layers: between them, finite.
  RoughCrossing(const Interface& upper, const Interface& lower, const DirectionSets& above,
                const DirectionSets& between, const DirectionSets& below,
                std::vector<const Layer*> layers, int modes);

  /// [mode], rows w_o, columns w_i, those asked for; light travels down, or up.
  std::vector<Eigen::MatrixXd> down, up;

  /// The share that crosses the layers along |mu'|.
  [[nodiscard]] double survives(double mu, bool travels_down) const;

 private:
  std::vector<const Layer*> layers_;
};

}  // namespace lamella
