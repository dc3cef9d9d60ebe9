#include "volume/run/first_check.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <vector>

namespace lamella {
namespace {

constexpr double kEffectiveEvents = 100, kRounding = 1e-4;
constexpr int kPatches = 4;  // in mu^2 and in phi

// The largest deviation of all quantities so far, in standard errors.
struct Deviations {
  double largest = 0;
  int quantities = 0;

  void add(const Estimate& walked, double exact, double bound) {
    const double error = walked.standard_error;
    const bool counts =
        error > 0 && walked.value * walked.value >= kEffectiveEvents * error * error;
    if (!counts) return;
    ++quantities;
    const double off = std::abs(walked.value - exact) - bound - kRounding * std::abs(exact);
    largest = std::max(largest, off / error);
  }
};

void add_side(const Simulation& simulation, bool up, Deviations& deviations) {
  const CellTargets& targets = simulation.targets();
  const CellGrid& grid = targets.grid;
  const LobeEstimate& exact = up ? simulation.closed_first().up : simulation.closed_first().down;
  const double solid_angle = grid.projected_solid_angle();
  const int rows = std::min(kPatches, grid.rows()), columns = std::min(kPatches, grid.columns());
  for (int c = 0; c < simulation.plan().channels; ++c) {
    double energy = 0, energy_bound = 0;
    for (int patch = 0; patch < rows * columns; ++patch) {
      std::vector<std::size_t> cells;
      double sum = 0, bound = 0;
      for (int cell = 0; cell < grid.cells(); ++cell) {
        const int row = cell / grid.columns() * rows / grid.rows();
        const int column = cell % grid.columns() * columns / grid.columns();
        if (row * columns + column != patch) continue;
        const auto k = static_cast<std::size_t>(c) * grid.cells() + cell;
        sum += exact.value[k];
        bound += exact.standard_error[k];
        cells.push_back(static_cast<std::size_t>(c) * targets.count() +
                        target_of(targets, up, cell));
      }
      const Estimate walked = batch_estimate(simulation.batches(), [&](const BatchTally& b) {
        double f = 0;
        for (const std::size_t k : cells) f += b.f[k];
        return f;
      });
      deviations.add(walked, sum, bound);
      energy += solid_angle * sum;
      energy_bound += solid_angle * bound;
    }
    const Estimate left = batch_estimate(simulation.batches(), [&](const BatchTally& b) {
      return (up ? b.energy.up : b.energy.down)[place(Order::one)][c];
    });
    deviations.add(left, energy, energy_bound);
  }
}

}  // namespace

double first_check(const Simulation& simulation) {
  if (simulation.order_one() == OrderOne::walked) return 1;
  Deviations deviations;
  const ClosedFirst& first = simulation.closed_first();
  if (!first.up.value.empty()) add_side(simulation, true, deviations);
  if (!first.down.value.empty()) add_side(simulation, false, deviations);
  if (first.uncollided)
    for (int c = 0; c < simulation.plan().channels; ++c)
      deviations.add(batch_estimate(simulation.batches(),
                                    [&](const BatchTally& b) { return b.energy.uncollided[c]; }),
                     *first.uncollided, 0);
  if (!std::isfinite(deviations.largest)) return 0;
  if (deviations.quantities == 0) return 1;
  const boost::math::students_t students(kBatches - 1.0);
  const double tail = boost::math::cdf(boost::math::complement(students, deviations.largest));
  return std::min(1.0, 2 * tail * deviations.quantities);
}

}  // namespace lamella
