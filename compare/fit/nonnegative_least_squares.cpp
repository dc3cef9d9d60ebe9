#include "compare/fit/nonnegative_least_squares.h"

#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

constexpr double kDependent = 1e-10;  // of a pivot, relative to its column
constexpr int kSteps = 3;             // per unknown, at most

// The solution over the columns that are in use, the others 0, by Cholesky's factor; what it cannot
// tell from the columns before is 0, too.
std::vector<double> solve(const NormalEquations& equations, const std::vector<bool>& used) {
  const int n = equations.unknowns();
  std::vector<int> at;
  std::vector<std::vector<double>> factor;
  for (int i = 0; i < n; ++i) {
    if (!used[i]) continue;
    std::vector<double> row;
    double pivot = equations.square(i, i);
    for (std::size_t j = 0; j < at.size(); ++j) {
      double sum = equations.square(i, at[j]);
      for (std::size_t k = 0; k < j; ++k) sum -= row[k] * factor[j][k];
      row.push_back(sum / factor[j][j]);
      pivot -= row[j] * row[j];
    }
    if (!(pivot > kDependent * equations.square(i, i))) continue;
    row.push_back(std::sqrt(pivot));
    at.push_back(i);
    factor.push_back(std::move(row));
  }
  const int m = static_cast<int>(at.size());
  std::vector<double> y(m), x(n);
  for (int i = 0; i < m; ++i) {
    y[i] = equations.right(at[i]);
    for (int k = 0; k < i; ++k) y[i] -= factor[i][k] * y[k];
    y[i] /= factor[i][i];
  }
  for (int i = m - 1; i >= 0; --i) {
    for (int k = i + 1; k < m; ++k) y[i] -= factor[k][i] * y[k];
    y[i] /= factor[i][i];
    x[at[i]] = y[i];
  }
  return x;
}

}  // namespace

NormalEquations::NormalEquations(int unknowns)
    : unknowns_(unknowns),
      squares_(static_cast<std::size_t>(unknowns) * unknowns),
      right_(unknowns) {}

void NormalEquations::add(std::span<const double> row, double b) {
  for (int i = 0; i < unknowns_; ++i) {
    for (int j = 0; j < unknowns_; ++j) squares_[i * unknowns_ + j] += row[i] * row[j];
    right_[i] += row[i] * b;
  }
}

void NormalEquations::fix(int k, double value) {
  for (int i = 0; i < unknowns_; ++i) {
    right_[i] -= squares_[i * unknowns_ + k] * value;
    squares_[i * unknowns_ + k] = squares_[k * unknowns_ + i] = 0;
  }
  right_[k] = 0;
}

std::vector<double> nonnegative_solution(const NormalEquations& equations) {
  const int n = equations.unknowns();
  std::vector<bool> used(n), refused(n);
  std::vector<double> x(n);
  for (int step = 0; step < kSteps * n; ++step) {
    // The unknown along which the sum of squares falls most steeply, in units of its column.
    int next = -1;
    double most = 0;
    for (int i = 0; i < n; ++i) {
      const double own = equations.square(i, i);
      if (used[i] || refused[i] || !(own > 0)) continue;
      double slope = equations.right(i);
      for (int j = 0; j < n; ++j) slope -= equations.square(i, j) * x[j];
      const double least = 1e-12 * std::abs(equations.right(i));
      if (slope > least && slope / std::sqrt(own) > most) {
        most = slope / std::sqrt(own);
        next = i;
      }
    }
    if (next < 0) break;
    used[next] = true;
    std::vector<double> free = solve(equations, used);
    if (!(free[next] > 0)) {  // others span it
      used[next] = false;
      refused[next] = true;
      continue;
    }
    // Back to the first bound on the way, whose unknown leaves.
    for (;;) {
      int first = -1;
      double share = 1;
      for (int i = 0; i < n; ++i) {
        if (!used[i] || !(free[i] < 0)) continue;
        const double own = x[i] / (x[i] - free[i]);
        if (first < 0 || own < share) {
          share = own;
          first = i;
        }
      }
      if (first < 0) break;
      for (int i = 0; i < n; ++i)
        if (used[i]) x[i] = std::max(x[i] + share * (free[i] - x[i]), 0.0);
      x[first] = 0;
      used[first] = false;
      free = solve(equations, used);
    }
    x = std::move(free);
  }
  return x;
}

std::vector<double> bounded_solution(NormalEquations equations, std::span<const double> most) {
  const int n = equations.unknowns();
  std::vector<double> fixed(n);
  for (;;) {
    std::vector<double> x = nonnegative_solution(equations);
    int farthest = -1;
    for (int k = 0; k < n; ++k)
      if (x[k] > most[k] && (farthest < 0 || x[k] * most[farthest] > x[farthest] * most[k]))
        farthest = k;
    if (farthest < 0) {
      for (int k = 0; k < n; ++k)
        if (fixed[k] > 0) x[k] = fixed[k];
      return x;
    }
    fixed[farthest] = most[farthest];
    equations.fix(farthest, most[farthest]);
  }
}

}  // namespace lamella
