#include "compare/truth/ground_truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <utility>

#include "compare/request/interrupt.h"
#include "compare/request/run_keeper.h"
#include "compare/truth/pilot.h"
#include "compare/truth/solved_texels.h"
#include "compare/truth/texel_mean.h"
#include "phase/math/degrees.h"
#include "phase/math/larger_error.h"
#include "volume/result/number_bytes.h"
#include "volume/result/run_bytes.h"
#include "volume/run/first_check.h"
#include "volume/solver/answer_check.h"
#include "volume/solver/deterministic_run.h"

namespace lamella {
namespace {

void warn_of_accuracy(const RunResult& run, double tolerance, const RunMonitor& monitor) {
  const DeterministicAccuracy& a = *run.accuracy;
  if (a.reached) return;
  monitor.warn(
      fmt::format("theta_i {:g}: the solver's bound is {:.1e} at worst after {}{}, short of "
                  "--tolerance {}; each "
                  "value has its own bound",
                  theta_degrees(run.incident), a.error,
                  a.harmonics ? fmt::format("spherical harmonics of degree {}", a.harmonics)
                              : fmt::format("{} nodes and {} modes", a.nodes, a.modes),
                  a.limit == DeterministicLimit::interrupted ? ", when it was interrupted" : "",
                  to_text(tolerance)));
}

double worst_bound(const std::vector<RunResult>& solved) {
  double worst = 0;
  for (const RunResult& run : solved) worst = larger_error(worst, run.accuracy->error);
  return worst;
}

// Where the solver ended, as files record it.
TruthRequest::SolverEnd solver_end(const RunResult& run) {
  const DeterministicAccuracy& a = *run.accuracy;
  return {a.nodes, a.channel_modes,
          a.harmonics > 0 ? std::optional(a.integrated_from) : std::nullopt};
}

std::string short_of_target(const RunResult& run, const TexelWalks& walked, double target) {
  std::string text = fmt::format(
      "theta_i {:g}: relative error {:.2g} of the mean over the map after {} walks, "
      "short of --target-error {}",
      theta_degrees(run.incident), walked.error, run.walks, to_text(target));
  return walked.of_texels >= target
             ? text +
                   fmt::format("; differences between texels leave {:.2g} of it", walked.of_texels)
             : text + "; raise --walks";
}

}  // namespace

std::optional<std::string> why_order_one_is_wrong(const RunResult& run) {
  if (!(run.order_one_p_value < kImplausibleFirst)) return std::nullopt;
  return fmt::format(
      "theta_i {1:g}: what {0} walks counted of order 1 is not what its closed form gives (p = "
      "{2:.1e}): one of them is at fault, please report it; order 1 is kept as walked",
      run.walks, theta_degrees(run.incident), run.order_one_p_value);
}

RunResult run_walks(Simulation& simulation, const StopRule& rule, const std::string& label,
                    const RunMonitor& monitor) {
  std::function<void(const Progress&)> progress;
  if (monitor.progress) progress = [&](const Progress& p) { monitor.progress(label, p); };
  const double seconds = run_kept(simulation, rule, progress, monitor);
  if (monitor.finished) monitor.finished();
  RunResult result = reduce(simulation);
  result.seconds = seconds;
  if (const auto reason = why_order_one_is_wrong(result)) monitor.warn(*reason);
  if (rule.target_error && result.walks >= rule.walks && !monitor.is_stopped()) {
    const double reached = largest_relative_error(simulation);
    if (reached > *rule.target_error)
      monitor.warn(fmt::format(
          "{}: relative error {:.2g} after {} walks, short of --target-error {}; raise --walks",
          label, reached, result.walks, to_text(*rule.target_error)));
  }
  return result;
}

GroundTruth::GroundTruth(TruthRequest request, Estimator of_walks, RunMonitor monitor)
    : request_(std::move(request)),
      of_walks_(of_walks),
      monitor_(std::move(monitor)),
      plan_(request_.texels.empty() ? plan_of(request_) : texel_plan(request_)),
      look_(request_, request_.directions.size()) {
  if (request_.texels.empty())
    check_estimator(request_);
  else
    check_texel_mean(request_);
  for (const std::string& warning : plan_.warnings) monitor_.warn(warning);
}

const EstimatorChoice& GroundTruth::choice() {
  if (choice_) return *choice_;
  if (monitor_.keeper) {
    const auto kept = monitor_.keeper->piece([&] {
      choose();
      return choice_bytes();
    });
    if (kept && !choice_) restore_choice(*kept);
  }
  if (!choice_) choose();
  return *choice_;
}

std::string GroundTruth::choice_bytes() const {
  NumberWriter out;
  out.put(static_cast<std::uint32_t>(choice_->estimator));
  out.put_text(choice_->reason);
  out.put(static_cast<std::uint64_t>(solved_.size()));
  for (const RunResult& run : solved_) out.put_text(to_bytes(run));
  for (const RunResult& run : map_errors_) out.put_text(to_bytes(run));
  out.put(static_cast<std::uint64_t>(texel_ends_.size()));
  for (const TruthRequest::SolverEnd& end : texel_ends_) {
    out.put(static_cast<std::int32_t>(end.nodes));
    for (const int count : end.modes) out.put(static_cast<std::int32_t>(count));
    out.put(static_cast<std::int32_t>(end.integrated_from.value_or(-1)));
  }
  return out.take();
}

void GroundTruth::restore_choice(std::string_view bytes) {
  NumberReader in(bytes);
  const auto estimator = static_cast<Estimator>(in.get<std::uint32_t>());
  if (estimator > Estimator::deterministic) throw DamagedBytes("it has an estimator that is none");
  EstimatorChoice choice{estimator, std::string(in.get_text()), nullptr};
  const auto count = in.get<std::uint64_t>();
  if (count != (estimator == Estimator::deterministic ? directions().size() : 0))
    throw DamagedBytes("it has another number of solved directions");
  std::vector<RunResult> solved;
  for (std::uint64_t k = 0; k < count; ++k) solved.push_back(run_from_bytes(in.get_text()));
  std::vector<RunResult> errors;
  if (!request_.texels.empty())
    for (std::uint64_t k = 0; k < count; ++k) errors.push_back(run_from_bytes(in.get_text()));
  const auto ended = in.get<std::uint64_t>();
  if (ended > (count > 0 ? request_.texels.size() : 0))
    throw DamagedBytes("it has more solved texels than there are");
  std::vector<TruthRequest::SolverEnd> ends;
  for (std::uint64_t k = 0; k < ended; ++k) {
    TruthRequest::SolverEnd end{in.get<std::int32_t>(), {}, std::nullopt};
    for (int& modes : end.modes) modes = in.get<std::int32_t>();
    if (const auto from = in.get<std::int32_t>(); from >= 0) end.integrated_from = from;
    ends.push_back(end);
  }
  in.end();
  CellGrid grid = request_.cells;
  grid.folded = plan_.folded && grid.phi_cells % 2 == 0;
  for (const auto* runs : {&solved, &errors})
    for (const RunResult& run : *runs)
      if (run.channels != plan_.channels || run.grid.cells() != grid.cells())
        throw DamagedBytes("it has solved cells of another grid");
  choice_ = std::move(choice);
  solved_ = std::move(solved);
  map_errors_ = std::move(errors);
  texel_ends_ = std::move(ends);
}

void GroundTruth::choose() {
  if (!request_.texels.empty()) return choose_for_texels();
  choice_ = choose_estimator(request_, of_walks_, monitor_.stop, monitor_.solver);
  if (choice_->solution) solve_cells();
  if (choice_->has_harmonics()) solve_harmonics();
  if (monitor_.solver && monitor_.finished) monitor_.finished();
  // A number of walks is an effort by itself; where time or error is, the cheaper walks win.
  if (!request_.estimator && choice_->estimator != Estimator::deterministic &&
      of_walks_ == Estimator::analog && (request_.effort.seconds || request_.effort.target_error)) {
    const Pilot found = pilot(request_, plan_, directions()[directions().size() / 2]);
    choice_->estimator = found.best;
    choice_->reason += "; " + to_text(found);
  }
}

void GroundTruth::choose_for_texels() {
  const std::vector<std::size_t> first = first_equals(request_.texels);
  const std::size_t different = count_different(first);
  std::string reason =
      fmt::format("the mean over a map walks through {} texels", request_.texels.size());
  const bool asked = request_.estimator == Estimator::deterministic;
  if (asked || (!request_.estimator && request_.given.empty())) {
    if (asked || different <= kMostSolvedTexels) {
      if (asked) warn_of_walk_settings();
      if (solve_texels(first)) return;
      reason += ", of which the solver does not answer all";
    } else {
      reason +=
          fmt::format(", {} of them different (--estimator deterministic solves each)", different);
    }
  }
  choice_ =
      EstimatorChoice{asked ? of_walks_ : request_.estimator.value_or(of_walks_), reason, nullptr};
}

bool GroundTruth::solve_texels(const std::vector<std::size_t>& first_equal) {
  const std::size_t count = first_equal.size(), different = count_different(first_equal);
  std::vector<std::size_t> last_use(count);
  for (std::size_t k = 0; k < count; ++k) last_use[first_equal[k]] = k;
  // Texels are solved without a keeper: their mean is one piece.
  RunMonitor of_texel{.stop = monitor_.stop, .solver = monitor_.solver};
  SolvedTexels texels;
  std::map<std::size_t, std::vector<RunResult>> solved;
  std::vector<TruthRequest::SolverEnd> ends;
  double seconds = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t first = first_equal[k];
    if (first == k) {
      if (k > 0 && is_stopped()) break;
      GroundTruth one(request_of_texel(request_, k, 1.0 / static_cast<double>(different)),
                      of_walks_, of_texel);
      one.plan_ = plan_of_texel(request_, k, plan_);
      if (one.choice().estimator != Estimator::deterministic) return false;
      for (const RunResult& run : one.solved_) seconds += run.seconds;
      solved[k] = std::move(one.solved_);
    }
    texels.add(solved.at(first));
    ends.push_back(solver_end(solved.at(first).front()));
    if (last_use[first] == k) solved.erase(first);
  }
  if (monitor_.solver && monitor_.finished) monitor_.finished();
  if (texels.count() < count)
    monitor_.warn(fmt::format("interrupted: {} of {} texels are solved, the mean is theirs",
                              texels.count(), count));
  solved_ = texels.mean();
  for (RunResult& run : solved_) run.seconds = seconds / static_cast<double>(solved_.size());
  map_errors_ = texels.map_errors();
  texel_ends_ = std::move(ends);
  choice_ = EstimatorChoice{
      Estimator::deterministic,
      request_.estimator
          ? "asked for"
          : fmt::format("the solver reaches {:.1e} on {} texels of the map, {} of them different",
                        worst_bound(solved_), texels.count(), different),
      nullptr};
  return true;
}

void GroundTruth::warn_of_walk_settings() const {
  for (const WalkSetting setting : request_.given)
    if (setting != WalkSetting::seconds)
      monitor_.warn(to_text(setting) + " means nothing to the deterministic estimator");
}

void GroundTruth::solve_harmonics() {
  warn_of_walk_settings();
  solved_ = harmonic_cells(request_, plan_, monitor_.stop, monitor_.solver);
  if (request_.estimator) {
    for (const RunResult& run : solved_)
      if (const auto reason = why_no_answer(run, request_.solver_end.has_value()))
        refuse_answer(request_.stack, *reason);
    return;
  }
  const auto reason = why_walks_are_better(solved_, request_);
  if (reason && !is_stopped()) {
    choice_ = EstimatorChoice{of_walks_, *reason, nullptr};
    solved_.clear();
  } else {
    choice_->reason = reached_by(solved_);
  }
}

void GroundTruth::solve_cells() {
  const bool open = !request_.estimator;
  warn_of_walk_settings();
  const auto solve = [&](const DeterministicSolution& solution) {
    return deterministic_runs(solution, plan_, directions(), request_.cells, request_.tolerance,
                              monitor_.stop, monitor_.solver);
  };
  solved_ = solve(*choice_->solution);
  if (!(worst_bound(solved_) <= request_.tolerance) && choice_->solution->accuracy().reached &&
      !is_stopped()) {
    const std::shared_ptr<const DeterministicSolution> finer =
        refined(request_, monitor_.stop, monitor_.solver);
    // An interrupt may have left it coarser than what is there, or it has no answer.
    if (finer->accuracy().limit != DeterministicLimit::interrupted &&
        finer->accuracy().is_answer()) {
      choice_->solution = finer;
      solved_ = solve(*choice_->solution);
      if (open) choice_->reason = reached_by(*choice_->solution);
    }
  }
  if (!open) {
    for (const RunResult& run : solved_)
      if (const auto reason = why_no_answer(run, request_.solver_end.has_value()))
        refuse_answer(request_.stack, *reason);
    return;
  }
  const auto reason = why_walks_are_better(solved_, request_);
  // A stopped walk would keep less than a solution with wide bounds does, but not less than none.
  if (reason &&
      (!is_stopped() || std::any_of(solved_.begin(), solved_.end(), [this](const auto& run) {
        return why_no_answer(run, request_.solver_end.has_value()).has_value();
      }))) {
    choice_ = EstimatorChoice{of_walks_, *reason, nullptr};
    solved_.clear();
  } else if (worst_bound(solved_) > request_.tolerance) {
    choice_->reason += fmt::format(", but no more than {:.1e} in cells", worst_bound(solved_));
  }
}

bool GroundTruth::goes_on(std::size_t k) const {
  return k < directions().size() && (k == 0 || !is_stopped() || k < solved_.size());
}

Truth GroundTruth::find(std::size_t k, std::optional<std::uint64_t> walks) {
  const Direction wi = directions()[k];
  const Estimator estimator = choice().estimator;
  Truth truth;
  if (estimator == Estimator::deterministic) {
    truth.run = solved_[k];
    if (!map_errors_.empty()) truth.map_error = map_errors_[k];
    warn_of_accuracy(truth.run, request_.tolerance, monitor_);
    return truth;
  }
  if (!request_.texels.empty()) {
    StopRule of_texels = walks ? request_.effort : look_.next();
    of_texels.walks = walks.value_or(of_texels.walks);
    TexelWalks walked = walk_texels(request_, plan_, wi, estimator, of_texels, monitor_);
    truth.batches = std::move(walked.batches);
    if (monitor_.finished) monitor_.finished();
    truth.run = reduce(*truth.batches);
    truth.run.seconds = walked.seconds;
    if (is_stopped()) monitor_.warn("interrupted: a part of the map has no walks");
    if (of_texels.target_error && walked.error > *of_texels.target_error && !is_stopped())
      monitor_.warn(short_of_target(truth.run, walked, *of_texels.target_error));
    return truth;
  }
  truth.batches = std::make_unique<Simulation>(request_.stack, plan_, wi, estimator, request_.cells,
                                               request_.seed);
  StopRule rule = walks ? request_.effort : look_.next();
  rule.walks = walks.value_or(rule.walks);
  const std::string label = fmt::format("theta_i {:g}", theta_degrees(wi));
  truth.run = run_walks(*truth.batches, rule, label, monitor_);
  if (look_.has_clock() && truth.run.walks < rule.walks && !is_stopped())
    monitor_.warn(first_look_text(label, truth.run.walks, rule));
  return truth;
}

}  // namespace lamella
