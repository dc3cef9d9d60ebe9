#include "compare/judge/missing_light.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lamella {
namespace {

double square(double x) { return x * x; }

// The least sum of (d - m)^2 over m >= 0 with sum of m <= budget: m = max(d - level, 0), the level
// such that the budget is used up, or 0 (water filling; Karush, Kuhn and Tucker's conditions).
double least_sum(std::vector<double> difference, double budget) {
  std::sort(difference.begin(), difference.end(), std::greater<>());
  double above = 0, level = 0;
  for (std::size_t k = 0; k < difference.size() && difference[k] > 0; ++k) {
    above += difference[k];
    const double next = k + 1 < difference.size() ? std::max(difference[k + 1], 0.0) : 0.0;
    const auto count = static_cast<double>(k + 1);
    level = std::max((above - budget) / count, 0.0);
    if (level >= next) break;
  }
  double sum = 0;
  for (const double d : difference) sum += square(std::min(d, level));
  return sum;
}

// Convex in m: largest where one cell has all the missing light, the one where the model is lowest.
double most_sum(std::span<const double> difference, double budget) {
  const double lowest = *std::min_element(difference.begin(), difference.end());
  double sum = 0;
  for (const double d : difference) sum += square(d);
  return sum + std::max(0.0, budget * (budget - 2 * lowest));
}

}  // namespace

bool is_cut(const RunResult& run, Order order) {
  if (run.is_bounded()) return false;
  if (order == Order::zero) return false;
  if (order != Order::all && order != Order::scattered && order != Order::four_plus &&
      order != Order::multiple && static_cast<std::uint64_t>(order) + 1 <= run.max_order)
    return false;
  for (int c = 0; c < run.channels; ++c)
    if (run.unresolved[c].value > 0) return true;
  return false;
}

std::vector<double> missing_energy(const RunResult& run, Order order) {
  std::vector<double> missing(run.channels);
  if (!is_cut(run, order)) return missing;
  for (int c = 0; c < run.channels; ++c) {
    const Estimate& cut = run.unresolved[c];
    missing[c] = std::min(1.0, cut.value + kUnresolvedErrors * cut.standard_error);
  }
  return missing;
}

SquaredDifferences squared_differences(std::span<const double> model, std::span<const double> truth,
                                       std::span<const double> budget) {
  const std::size_t cells = truth.size() / budget.size();
  SquaredDifferences out;
  for (std::size_t c = 0; c < budget.size(); ++c) {
    std::vector<double> difference(cells);
    for (std::size_t k = 0; k < cells; ++k)
      difference[k] = model[c * cells + k] - truth[c * cells + k];
    out.most += most_sum(difference, budget[c]) / static_cast<double>(truth.size());
    out.least += least_sum(std::move(difference), budget[c]) / static_cast<double>(truth.size());
  }
  return out;
}

double most_mean_square(std::span<const double> truth, std::span<const double> budget) {
  const std::size_t cells = truth.size() / budget.size();
  double sum = 0;
  for (std::size_t c = 0; c < budget.size(); ++c) {
    const auto own = truth.subspan(c * cells, cells);
    for (const double f : own) sum += square(f);
    sum += budget[c] * (budget[c] + 2 * *std::max_element(own.begin(), own.end()));
  }
  return sum / static_cast<double>(truth.size());
}

}  // namespace lamella
