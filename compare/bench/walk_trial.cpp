#include "compare/bench/walk_trial.h"

#include <algorithm>
#include <optional>
#include <string>

#include "compare/request/stopwatch.h"

namespace lamella {
namespace {

// Variance per walk of f, summed over targets: of all orders together, or of one slot.
double variance_of_targets(const Simulation& simulation, std::optional<int> slot) {
  const std::size_t count = simulation.batches()[0].f.size() / kTallyOrders;
  double sum = 0;
  for (std::size_t j = 0; j < count; ++j) {
    const Estimate e = batch_estimate(simulation.batches(), [&](const BatchTally& b) {
      double f = 0;
      for (int o = slot.value_or(0); o < (slot ? *slot + 1 : kTallyOrders); ++o)
        f += b.f[o * count + j];
      return f;
    });
    sum += variance_per_walk(e, simulation.walks());
  }
  return sum;
}

}  // namespace

double variance_per_walk(Estimate e, std::uint64_t walks) {
  return e.standard_error * e.standard_error * static_cast<double>(walks);
}

std::uint64_t walks_for(double seconds, Simulation& simulation) {
  const std::uint64_t stride = simulation.stride();
  std::uint64_t walks = std::max<std::uint64_t>(4 * kBatches, stride);
  for (;;) {
    const double taken = seconds_of([&] { simulation.advance(simulation.walks() + walks); });
    if (taken > seconds / 4)
      return stride * std::max<std::uint64_t>(
                          1, static_cast<std::uint64_t>(static_cast<double>(walks) * seconds /
                                                        taken / static_cast<double>(stride)));
    walks *= 4;
  }
}

BenchmarkRow time_variance_row(Simulation& ours, Simulation& theirs, const BenchmarkEffort& effort,
                               std::uint64_t their_share) {
  const std::uint64_t walks = walks_for(effort.repetition_seconds, ours);
  const std::uint64_t before = ours.collisions();
  const InterleavedTimes times = interleave(
      effort.repetitions, [&] { ours.advance(ours.walks() + walks); },
      [&] { theirs.advance(theirs.walks() + walks * their_share); });
  const auto ratio = [&](std::optional<int> slot) {
    return variance_of_targets(theirs, slot) / variance_of_targets(ours, slot);
  };
  const double variance_ratio = ratio({});
  BenchmarkRow row{.what = "", .kind = "walk"};
  row.seconds = times.total_first();
  row.collisions_per_second_per_core =
      static_cast<double>(ours.collisions() - before) / times.total_first();
  row.ratio_to_baseline = times.median_ratio() / static_cast<double>(their_share) * variance_ratio;
  row.extra = {{"walks", ours.walks()}, {"variance_ratio", variance_ratio}};
  if (ours.sampling() == Sampling::rqmc)
    for (int slot = 0; slot < 3; ++slot)
      row.extra["variance_ratio_order_" + std::to_string(slot + 1)] = ratio(slot);
  return row;
}

}  // namespace lamella
