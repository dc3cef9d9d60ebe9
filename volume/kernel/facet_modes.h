#pragma once

#include <Eigen/Core>
#include <vector>

#include "volume/kernel/facet_profile.h"

namespace lamella {

/// Azimuthal modes of facets between lists of directions: matrices [mode], rows w_o, columns w_i,
/// nodes first, then directions that are asked for. A lobe may be narrower than the spacing of the
/// nodes. A value at a node therefore stands for its neighbourhood: u^3 times the radiance is taken
/// as a polynomial through the nodes of a panel, and the node values make sums over the nodes exact
/// for that polynomial,
///   f_jk = u_j^3 / (mu_j w_j) integral of l_j(u) / u^3 f(mu(u), mu_k) mu mu'(u) du,
/// l_j Lagrange's polynomials, by Gauss-Legendre on intervals that double in length away from the
/// lobe and end at every edge of f. With u^3 the sum over two lists of these values is the sum of
/// their projections onto the polynomials, and cannot blow up; energy is exact. Between two nodes
/// the mean is over w_o; between two directions that are asked for, the value is f itself.
class FacetModes {
 public:
  /// out, in: the media of w_o and w_i. asked_*: cosines there. with_asked_pairs: else f between
  /// two of them is left at 0.
  FacetModes(const FacetProfile& profile, const DirectionSets& out,
             const Eigen::VectorXd& asked_out, const DirectionSets& in,
             const Eigen::VectorXd& asked_in, int modes, bool with_asked_pairs);

  /// [mode]
  std::vector<Eigen::MatrixXd> f;
  /// Integral of f mu_o over the hemisphere of w_o, by column: the energy reflected or transmitted.
  Eigen::RowVectorXd energy;
};

}  // namespace lamella
