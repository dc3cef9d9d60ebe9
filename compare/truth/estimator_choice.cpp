#include "compare/truth/estimator_choice.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "compare/request/errors.h"
#include "phase/math/larger_error.h"
#include "phase/parameters/parameters.h"
#include "volume/harmonics/harmonic_run.h"
#include "volume/harmonics/layer_blocks.h"
#include "volume/solver/answer_check.h"
#include "volume/solver/deterministic_run.h"

namespace lamella {
namespace {

// What `auto` lets the solver spend: beyond it walks are the faster way to a useful answer.
constexpr int kTrialNodes = 64, kTrialModes = 64;
constexpr double kTrialSeconds = 20;
constexpr double kNarrow = 0.2;          // in spherical harmonics
constexpr double kNarrowBoundary = 0.3;  // where a boundary differs along x and y
constexpr double kSeconds = 60;  // of a solution that was asked for, unless --time says otherwise
// Where cells miss the tolerance with kSolverShare of it.
constexpr double kRefinedShare = 0.1;

std::string cost_of(const DeterministicAccuracy& a) {
  return fmt::format("{:.1e} with {} nodes and {} modes", a.error, a.nodes, a.modes);
}

// What the walks of the request leave of an energy at best; of a cell they leave more.
double error_of_walks(const TruthRequest& request) {
  return 1 / std::sqrt(static_cast<double>(request.effort.walks));
}

// A repeated run takes no notice of the clock: it goes as far as the first one went.
void end_where_it_ended(DeterministicOptions& solver, const TruthRequest& request) {
  if (!request.solver_end) return;
  solver.max_nodes = request.solver_end->nodes;
  solver.last_modes = request.solver_end->modes;
  solver.max_seconds = std::numeric_limits<double>::infinity();
}

std::optional<std::string> why_no_solver(const Stack& stack) {
  const bool symmetric = stack.grains() || stack.has_grid() || stack.is_symmetric_about_z();
  return symmetric ? why_not_deterministic(stack) : why_not_harmonic(stack);
}

}  // namespace

void check_estimator(const TruthRequest& request) {
  if (request.estimator != Estimator::deterministic) return;
  if (const auto reason = why_no_solver(request.stack))
    throw UsageError(fmt::format(
        "--estimator: found \"deterministic\" for {}, but {}; allowed: auto, analog, next-event",
        request.stack.name, *reason));
}

EstimatorChoice choose_estimator(const TruthRequest& request, Estimator of_walks,
                                 const StopFlag* stop, const SolverReport& report) {
  const Stack& stack = request.stack;
  if (request.estimator && *request.estimator != Estimator::deterministic)
    return {*request.estimator, "asked for", nullptr};
  check_estimator(request);
  if (request.estimator && !stack.is_symmetric_about_z())
    return {Estimator::deterministic, "asked for", nullptr};
  DeterministicOptions solver{.tolerance = kSolverShare * request.tolerance,
                              .isa = request.isa,
                              .stop = stop,
                              .report = report};
  if (request.estimator == Estimator::deterministic) {
    solver.max_seconds = request.effort.seconds.value_or(kSeconds);
    end_where_it_ended(solver, request);
    const auto solution =
        std::make_shared<const DeterministicSolution>(solve_deterministic(stack, solver));
    if (const auto reason = why_no_answer(solution->accuracy())) refuse_answer(stack, *reason);
    return {Estimator::deterministic, "asked for", solution};
  }
  if (!request.given.empty())
    return {of_walks, fmt::format("{} asks for walks", to_text(request.given.front())), nullptr};
  if (const auto reason = why_no_solver(stack)) return {of_walks, *reason, nullptr};
  if (has_anisotropic_boundaries(stack) && narrowest_feature(stack) < kNarrowBoundary)
    return {of_walks,
            fmt::format("a boundary differs along x and y, and the stack scatters as narrowly as "
                        "{:.2g}, which takes --estimator deterministic minutes",
                        narrowest_feature(stack)),
            nullptr};
  if (!stack.is_symmetric_about_z() && narrowest_feature(stack) < kNarrow)
    return {of_walks,
            fmt::format("the stack is not symmetric about the normal and scatters as narrowly as "
                        "{:.2g}, which takes --estimator deterministic minutes",
                        narrowest_feature(stack)),
            nullptr};
  if (!stack.is_symmetric_about_z())
    return {Estimator::deterministic,
            "the stack is not symmetric about the normal, which spherical harmonics are made for",
            nullptr};
  solver.max_nodes = kTrialNodes;
  solver.max_modes = kTrialModes;
  solver.max_seconds = kTrialSeconds;
  end_where_it_ended(solver, request);
  const auto solution =
      std::make_shared<const DeterministicSolution>(solve_deterministic(stack, solver));
  const DeterministicAccuracy& reached = solution->accuracy();
  if (const auto reason = why_no_answer(reached))
    return {of_walks, "the solver has no answer: " + *reason, nullptr};
  if (reached.reached) return {Estimator::deterministic, reached_by(*solution), solution};
  // A walk would keep no more than its first checkpoint of one direction.
  if (reached.limit == DeterministicLimit::interrupted && reached.error < 1)
    return {Estimator::deterministic, reached_by(*solution) + ", when it was interrupted",
            solution};
  const std::string short_of = fmt::format("short of --tolerance {}", to_text(request.tolerance));
  const double of_walks_at_best = error_of_walks(request);
  const std::string walks_leave =
      fmt::format("{:.0e} walks leave {:.0e} of an energy at best",
                  static_cast<double>(request.effort.walks), of_walks_at_best);
  if (reached.error <= of_walks_at_best)
    return {Estimator::deterministic,
            fmt::format("{}, {}; {}", reached_by(*solution), short_of, walks_leave), solution};
  return {of_walks,
          fmt::format("the solver reaches no more than {}, {}; {}", cost_of(reached), short_of,
                      walks_leave),
          nullptr};
}

void refuse_answer(const Stack& stack, const std::string& reason) {
  throw NoAnswerError(fmt::format(
      "--estimator deterministic: the solver has no answer for {}: {}; allowed: auto, analog, "
      "next-event",
      stack.name, reason));
}

std::optional<std::string> why_walks_are_better(const std::vector<RunResult>& solved,
                                                const TruthRequest& request) {
  double worst = 0;
  for (const RunResult& run : solved) {
    if (auto reason = why_no_answer(run, request.solver_end.has_value()))
      return "the solver has no answer: " + *reason;
    worst = larger_error(worst, run.accuracy->error);
  }
  if (solved.empty() || worst <= request.tolerance) return std::nullopt;
  // Of a cell, were the light spread evenly over all of them.
  const double of_walks =
      error_of_walks(request) * std::sqrt(static_cast<double>(solved.front().grid.cells()));
  if (worst <= of_walks) return std::nullopt;
  return fmt::format(
      "the solver reaches no more than {:.1e} in cells, where {:.0e} walks leave {:.0e}", worst,
      static_cast<double>(request.effort.walks), of_walks);
}

std::string reached_by(const DeterministicSolution& solution) {
  return "the solver reaches " + cost_of(solution.accuracy());
}

std::shared_ptr<const DeterministicSolution> refined(const TruthRequest& request,
                                                     const StopFlag* stop,
                                                     const SolverReport& report) {
  DeterministicOptions solver{.tolerance = kRefinedShare * request.tolerance,
                              .max_seconds = request.effort.seconds.value_or(kSeconds),
                              .isa = request.isa,
                              .stop = stop,
                              .report = report};
  end_where_it_ended(solver, request);
  return std::make_shared<const DeterministicSolution>(solve_deterministic(request.stack, solver));
}

namespace {

HarmonicOptions harmonic_options(const TruthRequest& request, const StopFlag* stop,
                                 const SolverReport& report) {
  HarmonicOptions solver{
      .tolerance = request.tolerance,
      .max_seconds = request.estimator ? request.effort.seconds.value_or(kSeconds) : kTrialSeconds,
      .isa = request.isa,
      .stop = stop,
      .report = report};
  if (request.solver_end) {
    solver.max_degree = request.solver_end->modes[0] - 1;
    solver.integrate_from = request.solver_end->integrated_from;
    solver.max_seconds = std::numeric_limits<double>::infinity();
  }
  return solver;
}

}  // namespace

std::vector<RunResult> harmonic_cells(const TruthRequest& request, const Plan& plan,
                                      const StopFlag* stop, const SolverReport& report) {
  return harmonic_runs(request.stack, plan, request.directions, request.cells,
                       harmonic_options(request, stop, report));
}

std::vector<HarmonicPair> harmonic_values(const TruthRequest& request,
                                          std::span<const std::pair<Direction, Direction>> pairs,
                                          const StopFlag* stop, const SolverReport& report,
                                          DeterministicAccuracy& accuracy) {
  return harmonic_pairs(request.stack, pairs, harmonic_options(request, stop, report), accuracy);
}

std::string reached_by(const std::vector<RunResult>& harmonic_cells) {
  double worst = 0;
  for (const RunResult& run : harmonic_cells) worst = larger_error(worst, run.accuracy->error);
  return fmt::format("the solver reaches {:.1e} with spherical harmonics of degree {}", worst,
                     harmonic_cells.front().accuracy->harmonics);
}

std::string estimator_text(const EstimatorChoice& choice, const TruthRequest& request) {
  return fmt::format("{} estimator{}, {}", to_text(choice.estimator),
                     request.estimator ? "" : fmt::format(" (auto: {})", choice.reason),
                     choice.estimator == Estimator::deterministic
                         ? fmt::format("tolerance {}", to_text(request.tolerance))
                         : fmt::format("seed {}", request.seed));
}

}  // namespace lamella
