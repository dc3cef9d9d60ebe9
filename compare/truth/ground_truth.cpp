#include "compare/truth/ground_truth.h"

#include <fmt/format.h>

#include <algorithm>

#include "compare/truth/pilot.h"
#include "volume/solver/deterministic_run.h"

namespace lamella {
namespace {

void warn_of_accuracy(const RunResult& run, const Options& options) {
  const DeterministicAccuracy& a = *run.accuracy;
  if (a.reached) return;
  fmt::print(stderr,
             "lamella: warning: theta_i {:g}: the solver's bound is {:.1e} at worst after {} nodes "
             "and {} modes{}, short of --tolerance {}; each value has its own bound\n",
             theta_degrees(run.incident), a.error, a.nodes, a.modes,
             a.limit == DeterministicLimit::interrupted ? ", when it was interrupted" : "",
             to_text(options.tolerance));
}

double worst_bound(const std::vector<RunResult>& solved) {
  double worst = 0;
  for (const RunResult& run : solved) worst = std::max(worst, run.accuracy->error);
  return worst;
}

}  // namespace

GroundTruth::GroundTruth(const Stack& stack, const Options& options, CellGrid grid,
                         Estimator of_walks)
    : GroundTruth(stack, options, grid, of_walks, incident_directions(options, stack)) {}

GroundTruth::GroundTruth(const Stack& stack, const Options& options, CellGrid grid,
                         Estimator of_walks, std::vector<Direction> directions)
    : stack_(stack),
      options_(options),
      grid_(grid),
      of_walks_(of_walks),
      plan_(plan_of(options, stack)),
      directions_(std::move(directions)) {
  check_estimator(stack, options);
}

const EstimatorChoice& GroundTruth::choice() {
  if (choice_) return *choice_;
  catch_interrupts();
  choice_ = choose_estimator(stack_, options_, of_walks_);
  // A number of walks is an effort by itself; where time or error is, the cheaper walks win.
  if (options_.estimator == "auto" && !choice_->solution && of_walks_ == Estimator::analog &&
      (options_.seconds || options_.target_error)) {
    const Pilot found = pilot(stack_, plan_, directions_[directions_.size() / 2], grid_, options_);
    choice_->estimator = found.best;
    choice_->reason += "; " + to_text(found);
  }
  if (choice_->solution) {
    for (const std::string& option : options_.walk_options)
      if (option != "--time")
        fmt::print(stderr, "lamella: warning: {} means nothing to the deterministic estimator\n",
                   option);
    const auto solve = [&](const DeterministicSolution& solution) {
      return deterministic_runs(solution, plan_, directions_, grid_, options_.tolerance,
                                &interrupted);
    };
    solved_ = solve(*choice_->solution);
    if (worst_bound(solved_) > options_.tolerance && choice_->solution->accuracy().reached &&
        !interrupted) {
      const std::shared_ptr<const DeterministicSolution> finer = refined(stack_, options_);
      // An interrupt may have left it coarser than what is there.
      if (finer->accuracy().limit != DeterministicLimit::interrupted) {
        choice_->solution = finer;
        solved_ = solve(*choice_->solution);
        if (options_.estimator == "auto") choice_->reason = reached_by(*choice_->solution);
      }
    }
    if (options_.estimator == "auto" && worst_bound(solved_) > options_.tolerance)
      choice_->reason += fmt::format(", but no more than {:.1e} in cells", worst_bound(solved_));
  }
  return *choice_;
}

bool GroundTruth::goes_on(std::size_t k) const {
  return k < directions_.size() && (k == 0 || !interrupted || k < solved_.size());
}

Truth GroundTruth::find(std::size_t k, std::optional<std::uint64_t> walks) {
  const Direction wi = directions_[k];
  const Estimator estimator = choice().estimator;
  Truth truth;
  if (estimator == Estimator::deterministic) {
    truth.run = solved_[k];
    warn_of_accuracy(truth.run, options_);
    return truth;
  }
  truth.batches = std::make_unique<Simulation>(stack_, plan_, wi, estimator, grid_, options_.seed);
  Options options = options_;
  options.walks = walks.value_or(options.walks);
  truth.run =
      run_with_progress(*truth.batches, options, fmt::format("theta_i {:g}", theta_degrees(wi)));
  return truth;
}

std::vector<LobeComparison> judge(const Truth& truth, const Plan& plan, const BoundModel& model) {
  const RunResult& run = truth.run;
  std::vector<LobeComparison> lobes;
  for (const bool reflected : {true, false}) {
    if (!reflected && !plan.transmits) continue;
    const bool up = (run.incident.z > 0) == reflected;
    const ProjectedLobes projected =
        project(*model.model, *model.info, run.incident, run.grid, up, run.channels);
    for (LobeComparison& l : compare(run, truth.batches.get(), projected, reflected))
      lobes.push_back(std::move(l));
  }
  return lobes;
}

}  // namespace lamella
