#include "compare/fit/spongecake_truth.h"

#include <algorithm>
#include <chrono>
#include <memory>

#include "volume/run/simulation.h"
#include "volume/solver/deterministic_run.h"

namespace lamella {
namespace {

constexpr std::uint64_t kFewestWalks = 100000, kMostWalks = 64 * kFewestWalks;
constexpr double kAngles[] = {0, 30, 60, 80};
// After which no more walks are begun: narrow media of little absorption take long ones.
constexpr double kSeconds = 20;
// Of the solver, where it applies: what lobes leave over is far more than its tolerance.
DeterministicOptions solver_options() {
  DeterministicOptions options;
  options.tolerance = 1e-3;
  options.max_nodes = 32;
  options.max_modes = 64;
  options.max_seconds = 5;
  return options;
}

// Stacks with a preferred azimuth are lit from two.
std::vector<Direction> fit_directions(const Stack& stack) {
  std::vector<Direction> directions;
  for (const double theta : kAngles)
    for (const double phi : {0.0, 90.0})
      if (phi == 0 || (theta > 0 && !stack.is_symmetric_about_z()))
        directions.push_back(direction_from_degrees(theta, phi));
  return directions;
}

// By the solver; nothing where it does not apply or is not sharp enough.
std::optional<SpongecakeTruth> solved_fit(const Stack& stack, const SpongecakeEffort& effort) {
  if (!stack.is_symmetric_about_z() || why_not_deterministic(stack)) return std::nullopt;
  DeterministicOptions options = solver_options();
  options.isa = effort.isa ? *effort.isa : isa_from_text("auto");
  options.stop = effort.stop;
  const DeterministicSolution solution = solve_deterministic(stack, options);
  if (!solution.accuracy().is_answer() || (effort.stop && *effort.stop)) return std::nullopt;
  SpongecakeTruth truth;
  truth.runs = deterministic_runs(solution, make_plan(stack, {}), fit_directions(stack), kFitGrid,
                                  options.tolerance, effort.stop);
  truth.fit = fit_spongecake(stack, truth.runs);
  truth.is_sharp = truth.fit.walk_noise <= kFitNoise * truth.fit.relative_rmse;
  return truth.is_sharp ? std::optional(std::move(truth)) : std::nullopt;
}

}  // namespace

SpongecakeTruth fit_spongecake_to_truth(const Stack& stack, const SpongecakeEffort& effort) {
  const bool limited = effort.limits.max_order || effort.limits.thinning;
  if (!limited)
    if (std::optional<SpongecakeTruth> solved = solved_fit(stack, effort)) return *solved;
  return fit_spongecake_by_walks(stack, effort);
}

SpongecakeTruth fit_spongecake_by_walks(const Stack& stack, const SpongecakeEffort& effort) {
  Plan plan = make_plan(stack, effort.limits);
  plan.isa = effort.isa ? *effort.isa : isa_from_text("auto");
  std::vector<std::unique_ptr<Simulation>> simulations;
  for (const Direction wi : fit_directions(stack))
    simulations.push_back(std::make_unique<Simulation>(stack, plan, wi, Estimator::analog, kFitGrid,
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
