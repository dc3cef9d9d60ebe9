#include "compare/exchange/tensor_warp.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lamella {
namespace {

// The interval between nodes that x in [0, 1] lies in, and where in it.
std::pair<int, double> interval(double x, int nodes) {
  const double at = std::clamp(x, 0.0, 1.0) * (nodes - 1);
  const int k = std::min(static_cast<int>(at), nodes - 2);
  return {k, at - k};
}

// t in [0, 1] at which the integral of a linear function from a to b has the value y: a t +
// (b - a) t^2 / 2 = y, in the form that has no cancellation.
double inverse_of_linear(double a, double b, double y) {
  const double root = std::sqrt(std::max(a * a + 2 * (b - a) * y, 0.0));
  return a + root > 0 ? std::clamp(2 * y / (a + root), 0.0, 1.0) : 0;
}

}  // namespace

BilinearWarp::BilinearWarp(std::vector<double> nodes, int rows, int columns)
    : rows_(rows), columns_(columns), nodes_(std::move(nodes)) {
  const double du = 1.0 / (columns_ - 1), dv = 1.0 / (rows_ - 1);
  const auto integrate = [&] {
    conditional_.assign(nodes_.size(), 0);
    row_.assign(rows_, 0);
    marginal_.assign(rows_, 0);
    for (int r = 0; r < rows_; ++r) {
      const double* row = nodes_.data() + static_cast<std::size_t>(r) * columns_;
      double* sums = conditional_.data() + static_cast<std::size_t>(r) * columns_;
      for (int c = 1; c < columns_; ++c) sums[c] = sums[c - 1] + du * (row[c - 1] + row[c]) / 2;
      row_[r] = sums[columns_ - 1];
      if (r > 0) marginal_[r] = marginal_[r - 1] + dv * (row_[r - 1] + row_[r]) / 2;
    }
  };
  integrate();
  const double whole = marginal_.back();
  for (double& n : nodes_) n /= whole;
  integrate();
}

double BilinearWarp::density(SquarePoint p) const {
  const auto [r, y] = interval(p.v, rows_);
  const auto [c, x] = interval(p.u, columns_);
  const double* a = nodes_.data() + static_cast<std::size_t>(r) * columns_ + c;
  const double* b = a + columns_;
  return (1 - y) * ((1 - x) * a[0] + x * a[1]) + y * ((1 - x) * b[0] + x * b[1]);
}

SquarePoint BilinearWarp::sample(SquarePoint s) const {
  const double dv = 1.0 / (rows_ - 1), du = 1.0 / (columns_ - 1);
  const double m = std::clamp(s.v, 0.0, 1.0) * marginal_.back();
  const auto above = std::upper_bound(marginal_.begin() + 1, marginal_.end() - 1, m);
  const int r = static_cast<int>(above - marginal_.begin()) - 1;
  const double y = inverse_of_linear(row_[r], row_[r + 1], (m - marginal_[r]) / dv);
  const double* a = conditional_.data() + static_cast<std::size_t>(r) * columns_;
  const double* b = a + columns_;
  const auto sum = [&](int c) { return (1 - y) * a[c] + y * b[c]; };
  const double wanted = std::clamp(s.u, 0.0, 1.0) * sum(columns_ - 1);
  int low = 0, high = columns_ - 1;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    (sum(middle) <= wanted ? low : high) = middle;
  }
  const double* na = nodes_.data() + static_cast<std::size_t>(r) * columns_;
  const double* nb = na + columns_;
  const auto node = [&](int c) { return (1 - y) * na[c] + y * nb[c]; };
  const double x = inverse_of_linear(node(low), node(low + 1), (wanted - sum(low)) / du);
  return {(low + x) * du, (r + y) * dv};
}

BilinearWarp::Sums BilinearWarp::sums(SquarePoint p) const {
  const double dv = 1.0 / (rows_ - 1), du = 1.0 / (columns_ - 1);
  const auto [r, y] = interval(p.v, rows_);
  const auto [c, x] = interval(p.u, columns_);
  const double m = marginal_[r] + dv * y * (row_[r] + y * (row_[r + 1] - row_[r]) / 2);
  const std::size_t a = static_cast<std::size_t>(r) * columns_, b = a + columns_;
  const auto between = [y = y](double first, double second) {
    return (1 - y) * first + y * second;
  };
  const double n0 = between(nodes_[a + c], nodes_[b + c]);
  const double n1 = between(nodes_[a + c + 1], nodes_[b + c + 1]);
  const double sum =
      between(conditional_[a + c], conditional_[b + c]) + du * x * (n0 + x * (n1 - n0) / 2);
  return {m, sum, between(row_[r], row_[r + 1])};
}

SquarePoint BilinearWarp::invert(SquarePoint p) const {
  const Sums at = sums(p);
  return {at.row > 0 ? at.conditional / at.row : 0, at.marginal};
}

SquarePoint BilinearWarp::invert_mixed(std::span<const BilinearWarp> warps,
                                       std::span<const std::pair<std::size_t, double>> parts,
                                       SquarePoint p) {
  Sums all{0, 0, 0};
  for (const auto& [k, weight] : parts) {
    const Sums at = warps[k].sums(p);
    all.marginal += weight * at.marginal;
    all.conditional += weight * at.conditional;
    all.row += weight * at.row;
  }
  return {all.row > 0 ? all.conditional / all.row : 0, all.marginal};
}

double bilinear(std::span<const float> nodes, int rows, int columns, SquarePoint p) {
  const auto row = [&](int r, int c, double x) {
    const float* at = nodes.data() + static_cast<std::size_t>(r) * columns + c;
    return columns == 1 ? static_cast<double>(at[0])
                        : (1 - x) * static_cast<double>(at[0]) + x * static_cast<double>(at[1]);
  };
  const auto [c, x] = columns == 1 ? std::pair(0, 0.0) : interval(p.u, columns);
  if (rows == 1) return row(0, c, x);
  const auto [r, y] = interval(p.v, rows);
  return (1 - y) * row(r, c, x) + y * row(r + 1, c, x);
}

}  // namespace lamella
