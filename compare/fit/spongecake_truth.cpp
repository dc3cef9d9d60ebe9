#include "compare/fit/spongecake_truth.h"

#include <algorithm>
#include <chrono>
#include <memory>

#include "volume/run/simulation.h"

namespace lamella {
namespace {

constexpr std::uint64_t kFewestWalks = 100000, kMostWalks = 64 * kFewestWalks;
constexpr double kAngles[] = {0, 30, 60, 80};
// After which no more walks are begun: narrow media of little absorption take long ones.
constexpr double kSeconds = 20;

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
  const auto start = std::chrono::steady_clock::now();
  const auto seconds_left = [&] {
    return kSeconds -
           std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  for (std::uint64_t walks = kFewestWalks;; walks *= 4) {
    truth.runs.clear();
    for (std::size_t k = 0; k < simulations.size(); ++k) {
      const double share =
          std::max(seconds_left(), 0.05 * kSeconds) / static_cast<double>(simulations.size() - k);
      run(*simulations[k], {.walks = walks, .target_error = {}, .seconds = share}, {}, effort.stop);
      truth.runs.push_back(reduce(*simulations[k]));
    }
    truth.walks = walks;
    for (const RunResult& r : truth.runs) truth.walks = std::min(truth.walks, r.walks);
    truth.fit = fit_spongecake(stack, truth.runs);
    truth.is_sharp = truth.fit.walk_noise <= kFitNoise * truth.fit.relative_rmse;
    truth.is_late = truth.walks < walks && !is_stopped();
    if (truth.is_sharp || truth.is_late || walks >= kMostWalks || is_stopped()) return truth;
  }
}

}  // namespace lamella
