#pragma once

#include <Eigen/Core>
#include <vector>

#include "volume/kernel/facet_profile.h"

namespace lamella {

/// Azimuthal modes of facets between lists of directions: matrices [mode], rows w_o, columns w_i,
/// nodes first, then directions that are asked for. A lobe may be narrower than the nodes are
/// apart; so a value at a node is the mean over it: the moment of f with the Lagrange polynomial
/// of the node in its panel's u, the other direction fixed,
///   f_jk = integral of l_j(u) f(mu(u), mu_k) mu mu'(u) du / (mu_j w_j),
/// by Gauss-Legendre on intervals that double in length away from the lobe and end at every edge of
/// f. Sums over nodes are then exact for radiance that the polynomials hold. Between two nodes the
/// mean is over w_o; between two directions that are asked for f stands as it is.
class FacetModes {
 public:
  /// out, in: the media of w_o and w_i. asked_*: cosines there.
  FacetModes(const FacetProfile& profile, const DirectionSets& out,
             const Eigen::VectorXd& asked_out, const DirectionSets& in,
             const Eigen::VectorXd& asked_in, int modes);

  /// [mode]
  std::vector<Eigen::MatrixXd> f;
  /// Integral of f mu_o over the hemisphere of w_o, by column: what reflects or transmits.
  Eigen::RowVectorXd energy;
};

}  // namespace lamella
