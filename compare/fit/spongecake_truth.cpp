#include "compare/fit/spongecake_truth.h"

#include <memory>

#include "volume/run/simulation.h"

namespace lamella {
namespace {

constexpr std::uint64_t kFewestWalks = 100000, kMostWalks = 64 * kFewestWalks;
constexpr double kAngles[] = {0, 30, 60, 80};

}  // namespace

SpongecakeTruth fit_spongecake_by_walks(const Stack& stack, const SpongecakeEffort& effort) {
  Plan plan = make_plan(stack, effort.limits);
  plan.isa = effort.isa ? *effort.isa : isa_from_text("auto");
  std::vector<std::unique_ptr<Simulation>> simulations;
  for (const double theta : kAngles)
    simulations.push_back(std::make_unique<Simulation>(
        stack, plan, direction_from_degrees(theta, 0), Estimator::analog, kFitGrid,
        effort.seed + (std::uint64_t{1} << 32)));
  SpongecakeTruth truth;
  const auto is_stopped = [&] { return effort.stop && *effort.stop; };
  for (truth.walks = kFewestWalks;; truth.walks *= 4) {
    truth.runs.clear();
    for (const auto& simulation : simulations) {
      simulation->advance(truth.walks);
      truth.runs.push_back(reduce(*simulation));
    }
    truth.fit = fit_spongecake(stack, truth.runs);
    truth.is_sharp = truth.fit.noise <= kFitNoise * truth.fit.relative_rmse;
    if (truth.is_sharp || truth.walks >= kMostWalks || is_stopped()) return truth;
  }
}

}  // namespace lamella
