#pragma once

#include "volume/adding/pile_operator.h"

namespace lamella {

/// Fresnel's shares at a smooth boundary between cosines mu, mu2 in media of indices n, n2, which
/// belong together by Snell's law, one of them 0 at total reflection.
struct SmoothShares {
  double reflected, transmitted;  ///< each without cancellation
};
[[nodiscard]] SmoothShares smooth_shares(double n, double mu, double n2, double mu2);

/// A smooth boundary between two dielectrics, by Fresnel and Snell: nothing but beams. The media
/// have the indices of the two sets of directions.
[[nodiscard]] PileOperator smooth_boundary(const DirectionSets& above, const DirectionSets& below,
                                           int mode);

/// An opaque surface that reflects Lambert's way.
[[nodiscard]] PileOperator lambert_ground(double albedo, const DirectionSets& sets, int mode);

/// An opaque surface without diffuse light: `mirror` holds what it reflects of each direction of
/// `in` and of `out`, as order 1.
struct Mirror {
  Eigen::VectorXd in, out;
};
[[nodiscard]] PileOperator mirror_ground(const Mirror& mirror, const DirectionSets& sets, int mode);

}  // namespace lamella
