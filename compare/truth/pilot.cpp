#include "compare/truth/pilot.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace lamella {
namespace {

constexpr double kSeconds = 0.05;
constexpr std::uint64_t kFirst = 1 << 12, kMost = 1 << 20;

double cell_variance(const RunResult& run) {
  double sum = 0;
  for (const SideResult* side : {&run.reflected, &run.transmitted})
    for (const double se : side->lobes[kTallyOrders].standard_error)
      if (std::isfinite(se)) sum += se * se;
  return sum;
}

// Seconds times variance.
double cost(Simulation& simulation, bool of_energies) {
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  std::uint64_t walks = std::max(kFirst, simulation.stride());
  for (simulation.advance(walks); seconds() < kSeconds && walks < kMost;)
    simulation.advance(walks *= 2);
  const double taken = seconds();
  if (!of_energies) return taken * cell_variance(reduce(simulation));
  const double relative = largest_relative_error(simulation);
  return taken * relative * relative;
}

}  // namespace

Pilot pilot(const TruthRequest& request, const Plan& plan, Direction incident) {
  const auto cost_of = [&](Estimator estimator) {
    Simulation simulation(request.stack, plan, incident, estimator, request.cells, request.seed);
    const double found = cost(simulation, request.effort.target_error.has_value());
    return found > 0 ? found : std::numeric_limits<double>::infinity();
  };
  const double analog = cost_of(Estimator::analog), next_event = cost_of(Estimator::next_event);
  // Where neither scattered anything there is nothing to choose by.
  if (!(std::isfinite(analog) && std::isfinite(next_event))) return {};
  if (next_event < analog) return {Estimator::next_event, analog / next_event};
  return {Estimator::analog, next_event / analog};
}

std::string to_text(const Pilot& pilot) {
  return fmt::format("pilot: {} has {:.2g} times less time x variance", to_text(pilot.best),
                     pilot.advantage);
}

}  // namespace lamella
