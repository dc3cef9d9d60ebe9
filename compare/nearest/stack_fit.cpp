#include "compare/nearest/stack_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "compare/nearest/held_out.h"
#include "compare/request/errors.h"
#include "phase/stack/stack_file.h"
#include "volume/solver/deterministic_run.h"

namespace lamella {
namespace {

constexpr double kSolverStep = 5e-3, kWalkStep = 2e-2;  // of the ranges, for derivatives
constexpr int kFewestNodes = 12, kMostNodes = 32, kMostModes = 48;
constexpr double kCoarseTolerance = 2e-3;  // of searches, whose nodes are the fewest

// Seeds from that of a fit to that of its check on other directions.
constexpr std::uint64_t kHeldOutSeeds = 0x9E3779B97F4A7C15ULL;

// Nodes and modes of every solution.
struct SolverQuality {
  int nodes = 0;
  std::array<int, 3> modes{};
};

// The number of nodes before this one in a refinement (volume/solver/refinement.cpp).
int nodes_before(int nodes) { return nodes % 3 == 0 ? nodes / 3 * 2 : nodes / 4 * 3; }

// Numbers of a lobe, [channel][cell], on other cells, which may be folded where the lobe's are not
// and the other way round; grey for all channels.
std::vector<double> on_cells(const std::vector<double>& from, const CellGrid& grid, int channels,
                             const CellGrid& to, int to_channels) {
  std::vector<double> out;
  for (int c = 0; c < to_channels; ++c)
    for (int row = 0; row < to.rows(); ++row)
      for (int column = 0; column < to.columns(); ++column) {
        const auto at = [&](int j) {
          const int k = grid.folded ? std::min(j, grid.phi_cells - 1 - j) : j;
          const int channel = channels == 1 ? 0 : c;
          return from.empty() ? 0.0
                              : from[static_cast<std::size_t>(channel * grid.cells() +
                                                              row * grid.columns() + k)];
        };
        out.push_back(to.folded && !grid.folded ? (at(column) + at(to.phi_cells - 1 - column)) / 2
                                                : at(column));
      }
  return out;
}

// The lobes of a stack on a target's cells.
class StackLobes {
 public:
  StackLobes(const ParametricStack& stack, const FitTarget& target, const TargetTruths& truths,
             TruthRequest how, const RunMonitor& monitor)
      : stack_(stack), target_(target), how_(std::move(how)), stop_(monitor.stop) {
    how_.directions = truths.request.directions;
    how_.directions.resize(truths.truths.size());
    how_.cells = target.grid;
    how_.cells.folded = false;
  }

  /// Chooses how lobes are found. Throws UsageError.
  void choose() {
    std::vector<double> standard;
    for (const FreeNumber& free : stack_.free) standard.push_back(free.standard);
    TruthRequest request = how_;
    request.stack = stack_.at(standard);
    request.directions.resize(1);
    GroundTruth truth(request, Estimator::analog, {.stop = stop_});
    const EstimatorChoice& choice = truth.choice();
    const bool symmetric = request.stack.is_symmetric_about_z();
    reason_ = symmetric || choice.estimator != Estimator::deterministic
                  ? choice.reason
                  : "the stack is not symmetric about the normal";
    solves_ = symmetric && choice.solution;
    if (!solves_ && how_.estimator == Estimator::deterministic)
      throw UsageError(
          fmt::format("--estimator: found \"deterministic\", but {}; allowed: auto, "
                      "analog",
                      reason_));
    if (solves_) {
      const DeterministicAccuracy& reached = choice.solution->accuracy();
      quality_.nodes = std::clamp(reached.nodes, kFewestNodes, kMostNodes);
      for (std::size_t c = 0; c < 3; ++c)
        quality_.modes[c] = std::min(reached.channel_modes[c], kMostModes);
    }
    const bool given =
        std::find(how_.given.begin(), how_.given.end(), WalkSetting::walks) != how_.given.end();
    if (!solves_ && !given) how_.effort.walks = kFitWalks;
  }

  [[nodiscard]] bool solves() const { return solves_; }
  [[nodiscard]] std::string by() const {
    return solves_ ? fmt::format("solved with {} nodes and up to {} modes at every step",
                                 quality_.nodes,
                                 *std::max_element(quality_.modes.begin(), quality_.modes.end()))
                   : fmt::format(
                         "{} walks per direction with the same random numbers at every "
                         "step ({})",
                         how_.effort.walks, reason_);
  }

  [[nodiscard]] std::optional<std::vector<double>> means(std::span<const double> x, FitPass pass) {
    try {
      const std::vector<RunResult> found = runs(stack_.at(x), pass);
      return on_target(found, false);
    } catch (const StackFileError&) {
      return std::nullopt;
    } catch (const std::domain_error&) {
      return std::nullopt;
    }
  }
  /// The lobes at scaled numbers as the exact pass has them.
  [[nodiscard]] std::vector<RunResult> exact_runs(std::span<const double> x) {
    return runs(stack_.at(x), FitPass::exact);
  }
  /// The same on the target's cells, and the standard errors of walks, or nothing of the solver.
  struct Answer {
    std::vector<double> means, errors;
  };
  [[nodiscard]] Answer answer(std::span<const double> x) {
    const std::vector<RunResult> found = exact_runs(x);
    return {on_target(found, false), solves_ ? std::vector<double>() : on_target(found, true)};
  }
  /// Standard errors of walks.
  [[nodiscard]] std::vector<double> errors(std::span<const double> x) {
    return on_target(runs(stack_.at(x), FitPass::fine), true);
  }

 private:
  [[nodiscard]] std::vector<RunResult> runs(const Stack& stack, FitPass pass) {
    TruthRequest request = how_;
    request.stack = stack;
    std::vector<RunResult> found;
    if (solves_ && pass != FitPass::exact) {
      // Of two numbers of nodes the first has no error yet and the second is the last: both are
      // solved whatever the tolerance, which decides modes and what order 2 asks for.
      const double tolerance = pass == FitPass::coarse
                                   ? std::max(kCoarseTolerance, request.tolerance)
                                   : request.tolerance;
      DeterministicOptions options{.tolerance = kSolverShare * tolerance,
                                   .max_seconds = std::numeric_limits<double>::infinity(),
                                   .isa = request.isa,
                                   .stop = stop_};
      const int nodes = pass == FitPass::coarse ? kFewestNodes : quality_.nodes;
      options.max_nodes = nodes;
      options.min_nodes = nodes_before(nodes);
      options.last_modes = quality_.modes;
      const DeterministicSolution solution = solve_deterministic(stack, options);
      if (!solution.accuracy().is_answer()) throw std::domain_error("no solution");
      return deterministic_runs(solution, plan_of(request), request.directions, request.cells,
                                tolerance, stop_);
    }
    if (solves_) request.estimator = Estimator::deterministic;
    if (!solves_) request.estimator = Estimator::analog;
    GroundTruth truth(request, Estimator::analog, {.stop = stop_});
    for (std::size_t k = 0; k < request.directions.size(); ++k)
      found.push_back(truth
                          .find(k, solves_ ? std::optional<std::uint64_t>()
                                           : std::optional(request.effort.walks))
                          .run);
    return found;
  }

  // Numbers of the lobes "all" on the target's cells.
  [[nodiscard]] std::vector<double> on_target(const std::vector<RunResult>& runs,
                                              bool errors) const {
    std::vector<double> out;
    for (const TargetLobe& lobe : target_.lobes) {
      const RunResult& run = runs[lobe.run];
      const LobeEstimate& all =
          (lobe.reflected ? run.reflected : run.transmitted).lobes[Order::all];
      const std::vector<double> cells = on_cells(errors ? all.standard_error : all.value, run.grid,
                                                 run.channels, target_.grid, target_.channels);
      out.insert(out.end(), cells.begin(), cells.end());
    }
    return out;
  }

  const ParametricStack& stack_;
  const FitTarget& target_;
  TruthRequest how_;
  const StopFlag* stop_;
  bool solves_ = false;
  SolverQuality quality_;
  std::string reason_;
};

}  // namespace

NearestModels nearest_stack(const TargetTruths& target, const ParametricStack& stack,
                            const TruthRequest& how, FitNorm norm, FitSides sides,
                            const RunMonitor& monitor) {
  NearestModels nearest{.norm = norm,
                        .transmitted = sides == FitSides::all && target.plan.transmits,
                        .fits = {},
                        .refused = {},
                        .interrupted = target.interrupted};
  FitTarget cells;
  try {
    cells = fit_target(target.truths, nearest.transmitted);
  } catch (const std::invalid_argument& error) {
    throw UsageError(fmt::format("fit: {}: {}; allowed: a target that scatters light",
                                 target.request.stack.name, error.what()));
  }
  StackLobes lobes(stack, cells, target, how, monitor);
  lobes.choose();
  FitSubject subject{
      .name = stack.stack.name,
      .free = stack.free,
      .means = [&](std::span<const double> x, FitPass pass) { return lobes.means(x, pass); },
      .has_exact = lobes.solves(),
      .step = lobes.solves() ? kSolverStep : kWalkStep,
      .starts = kStackStarts,
      .tried = kStackTried};
  std::vector<double> standard;
  for (const FreeNumber& free : stack.free) standard.push_back(free.standard);
  if (!lobes.solves()) subject.own_error = lobes.errors(standard);
  ModelFit fit = fit_subject(subject, cells, norm, monitor.stop);
  fit.request.name = stack.stack.name;
  for (const FittedNumber& number : fit.numbers) {
    fit.request.values.emplace_back(number.number.name(), fmt::format("{:.6g}", number.value));
    fit.request.sources[number.number.name()] = "fitted";
  }
  fit.stack = stack.toml(fit.scaled);
  fit.runs = lobes.exact_runs(fit.scaled);
  fit.estimator = lobes.by();
  nearest.fits.push_back(std::move(fit));
  nearest.interrupted = nearest.interrupted || monitor.is_stopped();
  return nearest;
}

void judge_stack_held_out(NearestModels& nearest, const TargetTruths& others,
                          const ParametricStack& stack, TruthRequest how,
                          const RunMonitor& monitor) {
  FitTarget cells;
  try {
    cells = fit_target(others.truths, nearest.transmitted);
  } catch (const std::invalid_argument&) {
    return;
  }
  how.seed += kHeldOutSeeds;
  StackLobes lobes(stack, cells, others, how, monitor);
  lobes.choose();
  const StackLobes::Answer answer = lobes.answer(nearest.fits.front().scaled);
  nearest.held_out = {};
  for (const Truth& truth : others.truths)
    nearest.held_out.directions.push_back(truth.run.incident);
  nearest.held_out.relative_rmse = {held_out_error(cells, answer.means, answer.errors)};
}

BoundModel fitted_stack_model(const ModelFit& fit, ModelInfo& info) {
  info.name = fit.request.name;
  info.doc = "a stack whose numbers were fitted";
  BoundModel model;
  model.info = &info;
  for (const FittedNumber& number : fit.numbers) {
    ParameterInfo parameter;
    parameter.name = number.number.name();
    parameter.min = number.number.low;
    parameter.max = number.number.high;
    info.parameters.push_back(std::move(parameter));
    model.parameters.set(number.number.name(), number.value);
  }
  model.sources = fit.request.sources;
  return model;
}

StackComparison compare_with_stack(const TargetTruths& target, const ModelFit& fit,
                                   const BoundModel& model) {
  return compare_with(target, model, [&](std::size_t k, bool reflected) {
    const RunResult &truth = target.truths[k].run, &run = fit.runs[k];
    const SideResult& side = reflected ? run.reflected : run.transmitted;
    const SideResult& known = reflected ? truth.reflected : truth.transmitted;
    const auto on_truth = [&](const std::vector<double>& from) {
      return on_cells(from, run.grid, run.channels, truth.grid, truth.channels);
    };
    ProjectedLobes projected;
    for (std::size_t o = 0; o < side.lobes.size(); ++o) {
      const LobeEstimate& lobe = side.lobes[o];
      projected.has[o] = !lobe.value.empty() && !known.lobes[o].value.empty();
      if (!projected.has[o] && static_cast<Order>(o) != Order::all) continue;
      projected.has[o] = true;
      projected.lobes[o] = on_truth(lobe.value);
      projected.errors[o] = on_truth(lobe.standard_error);
      for (double& error : projected.errors[o]) error *= run.is_bounded() ? 1 : kErrorsAsBound;
    }
    return projected;
  });
}

}  // namespace lamella
