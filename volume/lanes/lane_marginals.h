#pragma once

#include <functional>
#include <vector>

namespace lamella {

/// Inverse marginal distributions for the visible normals of vMF flakes on lanes: 1 - v, v the
/// cosine with the mean normal, as three tables of kMarginalPieces cubics (four coefficients each,
/// powers of the place within the piece) in t in [0, 1]. E is an exponential number, up to
/// kLargestExponential: 1 - exp(-E) is the cumulative probability, and 1 - v as good as
/// proportional to E where flakes are narrow.
///   0: density v exp(kappa v) on [0, 1], from v = 1, t^2 proportional to E;
///   1: density x exp(-kappa x), x = -v on [0, 1], from x = 0, t^2 proportional to E;
///   2: density sqrt(1 - v^2) exp(kappa v), from v = 1, t^3 proportional to E.
/// The cumulative probability at a table's value differs from its own by less than 2e-6 (1: and
/// by what rounding 1 + x does to x).
[[nodiscard]] std::vector<float> vmf_marginals(double kappa);
/// Appends kMarginalPieces cubics of a monotone value(t), t in [0, 1]: slopes at most three times
/// those of the secants beside.
void append_cubics(std::vector<float>& table, const std::function<double(double)>& value);

}  // namespace lamella
