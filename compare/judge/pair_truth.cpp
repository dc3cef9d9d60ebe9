#include "compare/judge/pair_truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/judge/missing_light.h"
#include "compare/request/first_look.h"
#include "compare/request/percent.h"
#include "compare/request/run_keeper.h"
#include "compare/truth/point_truth.h"
#include "phase/math/larger_error.h"

namespace lamella {
namespace {

// Share of the light that cut walks may hold without a word.
constexpr double kToldCutEnergy = 1e-3;

// Energy per channel that cut walks may have taken from what left, 3 standard errors included.
Rgb cut_energy(const TruthValue& v) {
  Rgb energy;
  for (int c = 0; c < 3; ++c)
    if (v.unresolved[c].value > 0)
      energy[c] = v.unresolved[c].value + kUnresolvedErrors * v.unresolved[c].standard_error;
  return energy;
}

// The standard error, and f of what cut walks held, were it spread like Lambert's over one side.
Rgb error_of(const TruthValue& v) { return v.standard_error + 1 / kPi * cut_energy(v); }

// Where the clock of a first look ended walks: how many there were.
void warn_of_few_walks(const std::vector<TruthValue>& truth, const TruthRequest& request,
                       const RunMonitor& monitor) {
  std::uint64_t fewest = request.effort.walks;
  for (const TruthValue& v : truth)
    if (v.walks > 0) fewest = std::min(fewest, v.walks);
  if (fewest < request.effort.walks)
    monitor.warn(
        fmt::format("truth: {} of {} walks in {:g} s where they were fewest; walks=N for "
                    "more, see se",
                    fewest, request.effort.walks, kFirstLookSeconds));
}

void warn_of_cut_walks(const std::vector<TruthValue>& truth, const Plan& plan,
                       const RunMonitor& monitor) {
  double most = 0;
  for (const TruthValue& v : truth) most = std::max(most, cut_energy(v).max());
  if (most > kToldCutEnergy)
    monitor.warn(
        fmt::format("truth: walks that were cut after {} events hold {} of the light; se "
                    "has it spread over one side, a peak could lack more (--max-order)",
                    plan.max_order, percent_text(most)));
}

// Says where the solver's bound of a value is above the tolerance, which is relative to the mean
// over the azimuth; the value itself stands in for that mean here.
void warn_of_bounds(const std::vector<TruthValue>& truth, const DeterministicSolution& solution,
                    double tolerance, const RunMonitor& monitor) {
  double worst = 0;
  for (const TruthValue& v : truth)
    for (int c = 0; c < 3; ++c)
      if (v.f[c] != 0) worst = larger_error(worst, v.standard_error[c] / std::abs(v.f[c]));
  const DeterministicAccuracy& a = solution.accuracy();
  if (worst > tolerance && !a.reached)
    monitor.warn(fmt::format(
        "truth: the solver's bound is {:.1e} of a value at worst after {} nodes and {} modes, "
        "short of tolerance {}; see se",
        worst, a.nodes, a.modes, to_text(tolerance)));
}

// Of a stack without symmetry about the normal.
std::vector<TruthValue> truth_in_harmonics(const TruthRequest& request,
                                           const std::vector<DirectionPair>& pairs,
                                           const RunMonitor& monitor) {
  std::vector<std::pair<Direction, Direction>> directions;
  directions.reserve(pairs.size());
  for (const DirectionPair& pair : pairs) {
    check_pair(request.stack, pair);
    directions.emplace_back(pair.wi, pair.wo);
  }
  DeterministicAccuracy accuracy;
  std::vector<TruthValue> truth;
  for (const HarmonicPair& value :
       harmonic_values(request, directions, monitor.stop, monitor.solver, accuracy))
    truth.push_back({.f = value.f, .standard_error = value.error});
  if (!accuracy.reached)
    monitor.warn(fmt::format(
        "truth: the solver's bound is {:.1e} of a value at worst after spherical harmonics of "
        "degree {}, short of tolerance {}; see se",
        accuracy.error, accuracy.harmonics, to_text(request.tolerance)));
  return truth;
}

}  // namespace

PairTruth truth_of_pairs(const TruthRequest& request, const std::vector<DirectionPair>& pairs,
                         const RunMonitor& monitor) {
  PairTruth answer;
  std::vector<TruthValue> truth;
  const auto choose = [&] {
    answer.choice = choose_estimator(request, Estimator::next_event, monitor.stop, monitor.solver);
    if (!answer.is_solved()) return;
    truth = answer.choice.solution ? truth_at(*answer.choice.solution, pairs, monitor.solver)
                                   : truth_in_harmonics(request, pairs, monitor);
    if (const auto reason = why_no_answer(truth)) {
      if (request.estimator) refuse_answer(request.stack, *reason);
      answer.choice = EstimatorChoice{Estimator::next_event, *reason, nullptr};
    }
  };
  if (monitor.keeper && request.estimator == Estimator::deterministic) {
    const auto kept = monitor.keeper->piece([&] {
      choose();
      return to_bytes(truth);
    });
    answer.choice.estimator = Estimator::deterministic;
    if (truth.empty() && kept) truth = truth_values_from(*kept, pairs.size());
  } else {
    choose();
  }
  if (monitor.finished) monitor.finished();
  if (answer.is_solved()) {
    if (answer.choice.solution)
      warn_of_bounds(truth, *answer.choice.solution, request.tolerance, monitor);
  } else {
    const Plan plan = plan_of(request);
    for (const std::string& warning : plan.warnings) monitor.warn(warning);
    const FirstLook look(request, 1);
    truth = truth_at(request.stack, plan, pairs, request.effort.walks, request.seed, monitor,
                     look.has_clock() ? std::optional(kFirstLookSeconds) : request.effort.seconds);
    answer.fewest_walks = request.effort.walks;
    for (const TruthValue& v : truth)
      if (v.walks > 0) answer.fewest_walks = std::min(answer.fewest_walks, v.walks);
    if (!monitor.is_stopped() && look.has_clock()) warn_of_few_walks(truth, request, monitor);
    warn_of_cut_walks(truth, plan, monitor);
  }
  for (const TruthValue& v : truth) {
    answer.f.push_back(v.f);
    answer.error.push_back(error_of(v));
  }
  return answer;
}

}  // namespace lamella
