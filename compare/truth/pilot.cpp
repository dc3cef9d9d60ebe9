#include "compare/truth/pilot.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace lamella {
namespace {

constexpr double kSeconds = 0.05;
// Walks that a variance is taken from, unless they take longer than kMostSeconds.
constexpr std::uint64_t kFewest = 1 << 12, kMost = 1 << 20;
constexpr double kMostSeconds = 1;
// Orders of the walks by which the price of a collision is found.
constexpr std::uint64_t kPricedOrders = 64;

class Stopwatch {
 public:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

double cell_variance(const RunResult& run) {
  double sum = 0;
  for (const SideResult* side : {&run.reflected, &run.transmitted})
    for (const double se : side->lobes[Order::all].standard_error)
      if (std::isfinite(se)) sum += se * se;
  return sum;
}

// One walk per batch, or a realisation of grains.
std::uint64_t first_step(const Simulation& simulation) {
  return simulation.lane_use() ? kBatches : simulation.stride();
}

// Seconds times variance; infinite where there is no variance.
double cost(Simulation& simulation, bool of_energies) {
  const Stopwatch watch;
  std::uint64_t walks = first_step(simulation);
  for (simulation.advance(walks);
       watch.seconds() < (walks < kFewest ? kMostSeconds : kSeconds) && walks < kMost;)
    simulation.advance(walks *= 2);
  const double taken = watch.seconds();
  const double relative = of_energies ? largest_relative_error(simulation) : 0;
  const double found =
      taken * (of_energies ? relative * relative : cell_variance(reduce(simulation)));
  return found > 0 ? found : std::numeric_limits<double>::infinity();
}

}  // namespace

Pilot pilot(const TruthRequest& request, const Plan& plan, Direction incident) {
  const auto simulation_of = [&](Estimator estimator, const Plan& of) {
    return Simulation(request.stack, of, incident, estimator, request.cells, request.seed);
  };
  const bool of_energies = request.effort.target_error.has_value();
  Simulation by_analog = simulation_of(Estimator::analog, plan);
  const double analog = cost(by_analog, of_energies);

  // Next-event walks have the same collisions, each at a price of its own, which walks that are cut
  // early tell.
  Plan cut = plan;
  cut.max_order = std::min(plan.max_order, kPricedOrders);
  cut.thinning = {};
  Simulation priced = simulation_of(Estimator::next_event, cut);
  const Stopwatch watch;
  priced.advance(first_step(priced));
  const double price =
      watch.seconds() / static_cast<double>(std::max<std::uint64_t>(priced.collisions(), 1));
  const double per_walk =
      price * static_cast<double>(by_analog.collisions()) / static_cast<double>(by_analog.walks());
  Simulation by_next_event = simulation_of(Estimator::next_event, plan);
  const double first = per_walk * static_cast<double>(first_step(by_next_event));
  if (first > kMostSeconds) return {.first_seconds = first};

  const double next_event = cost(by_next_event, of_energies);
  // Where neither scattered anything there is nothing to choose by.
  if (!(std::isfinite(analog) && std::isfinite(next_event))) return {};
  if (next_event < analog) return {Estimator::next_event, analog / next_event};
  return {Estimator::analog, next_event / analog};
}

std::string to_text(const Pilot& pilot) {
  if (pilot.first_seconds > 0)
    return fmt::format("pilot: next-event was not tried, its first walks would take {:.2g} s",
                       pilot.first_seconds);
  return fmt::format("pilot: {} has {:.2g} times less time x variance", to_text(pilot.best),
                     pilot.advantage);
}

}  // namespace lamella
