#pragma once

#include <Eigen/Core>
#include <vector>

#include "volume/kernel/facet_profile.h"

namespace lamella {

/// Azimuthal modes of facets between lists of directions: matrices [mode], rows w_o, columns w_i,
/// nodes first, then directions that are asked for. A lobe may be narrower than the nodes are
/// apart; so a value at a node stands for its neighbourhood: radiance times u^3 is taken as a
/// polynomial through the nodes of a panel, and node values are such that sums over them are exact
/// for it,
///   f_jk = u_j^3 / (mu_j w_j) integral of l_j(u) / u^3 f(mu(u), mu_k) mu mu'(u) du,
/// l_j Lagrange's polynomials, by Gauss-Legendre on intervals that double in length away from the
/// lobe and end at every edge of f. With u^3 the sum over two lists of such values is that of their
/// projections onto the polynomials, and cannot blow up; and energy is exact. Between two nodes the
/// mean is over w_o; between two directions that are asked for f stands as it is.
class FacetModes {
 public:
  /// out, in: the media of w_o and w_i. asked_*: cosines there. with_asked_pairs: else f between
  /// two of them is left at 0.
  FacetModes(const FacetProfile& profile, const DirectionSets& out,
             const Eigen::VectorXd& asked_out, const DirectionSets& in,
             const Eigen::VectorXd& asked_in, int modes, bool with_asked_pairs);

  /// [mode]
  std::vector<Eigen::MatrixXd> f;
  /// Integral of f mu_o over the hemisphere of w_o, by column: what reflects or transmits.
  Eigen::RowVectorXd energy;
};

}  // namespace lamella
