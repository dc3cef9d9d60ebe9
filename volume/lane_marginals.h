#pragma once

#include <functional>
#include <vector>

namespace lamella {

/// Inverse marginal distributions for the visible normals of vMF flakes on lanes: 1 - v, v the
/// cosine with the mean normal, as four tables of kMarginalPieces cubics (four coefficients each,
/// powers of the place within the piece) in t in [0, 1], xi being the uniform number:
///   0: density v exp(kappa v) on [0, 1], t = sqrt(xi);
///   1: density x exp(-kappa x), x = -v on [0, 1], t = sqrt(xi);
///   2: density sqrt(1 - v^2) exp(kappa v), upper half, xi = t^3 / 2 from v = 1;
///   3: its lower half, xi = t^3 / 2 from v = -1.
/// kappa in [0, kLargestMarginalKappa]. The cumulative probability at a table's value differs from
/// xi by less than 2e-5.
[[nodiscard]] std::vector<float> vmf_marginals(double kappa);
/// Appends kMarginalPieces cubics of a monotone value(t), t in [0, 1]: slopes at most three times
/// those of the secants beside.
void append_cubics(std::vector<float>& table, const std::function<double(double)>& value);
inline constexpr double kLargestMarginalKappa = 50;

}  // namespace lamella
