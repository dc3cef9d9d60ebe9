#include "compare/library/reference_lobes.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "compare/judge/missing_light.h"
#include "compare/judge/pair_truth.h"
#include "compare/report/lobe_files.h"
#include "compare/truth/ground_truth.h"
#include "volume/harmonics/harmonic_run.h"
#include "volume/solver/answer_check.h"

namespace lamella {
namespace {

// The rest of an entry's time is for its points.
constexpr double kLobeShare = 0.6;
constexpr char kNoAnswer[] = "the solver has no answer";

// Points darker than this share of the brightest do not count in what an entry says of its points.
constexpr double kDarkPoint = 1e-6;
// Of f, at more than half of the points: walks do better than bounds above it.
constexpr double kWideBound = 0.01;

bool has_wide_bounds(const PairTruth& truth) {
  std::size_t wide = 0;
  for (std::size_t k = 0; k < truth.f.size(); ++k)
    wide += truth.error[k].max() > kWideBound * truth.f[k].max();
  return 2 * wide > truth.f.size();
}

bool is_harmonic(const Stack& stack) {
  return !stack.is_symmetric_about_z() && !stack.has_grid() && !stack.grains();
}

// Empty where the solver is to be tried.
std::string why_walks(const ReferenceEffort& effort, const Stack& stack) {
  if (effort.walks_only) return "asked for";
  return (is_harmonic(stack) ? why_not_harmonic(stack) : why_not_deterministic(stack)).value_or("");
}

// A stop flag that is set after some time, or once another is: cells and pairs have no clock.
class TimeLimit {
 public:
  TimeLimit(double seconds, const StopFlag* stop)
      : watcher_([this, seconds, stop] {
          const auto end =
              std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
          std::unique_lock lock(mutex_);
          while (!is_over_ && !is_set(stop) && std::chrono::steady_clock::now() < end)
            over_.wait_for(lock, std::chrono::milliseconds(20));
          if (!is_over_) flag_ = true;
        }) {}
  TimeLimit(const TimeLimit&) = delete;
  TimeLimit& operator=(const TimeLimit&) = delete;
  ~TimeLimit() {
    {
      const std::lock_guard lock(mutex_);
      is_over_ = true;
    }
    over_.notify_one();
    watcher_.join();
  }
  [[nodiscard]] const StopFlag* flag() const { return &flag_; }

 private:
  StopFlag flag_ = false;
  bool is_over_ = false;
  std::mutex mutex_;
  std::condition_variable over_;
  std::thread watcher_;  // last: it uses the others
};

// The monitor with the limit's flag in the place of its own.
RunMonitor limited(RunMonitor monitor, const TimeLimit& limit) {
  monitor.stop = limit.flag();
  return monitor;
}

TruthRequest request_of(const Stack& stack, const ReferenceEffort& effort) {
  TruthRequest request{.stack = stack, .directions = library_directions(stack)};
  request.cells = effort.cells;
  request.seed = effort.seed;
  request.isa = effort.isa;
  request.effort.walks = effort.walks;
  return request;
}

// Walks that the clock may end, shared by the directions.
TruthRequest by_walks(TruthRequest request, double seconds) {
  request.estimator = Estimator::analog;
  request.given = {WalkSetting::walks, WalkSetting::seconds};
  request.effort.seconds = seconds / static_cast<double>(request.directions.size());
  return request;
}

TruthRequest by_solver(TruthRequest request, double tolerance, double seconds) {
  request.estimator = Estimator::deterministic;
  request.tolerance = tolerance;
  request.effort.seconds = seconds;
  return request;
}

// The largest relative standard error of an energy above 1e-3.
double worst_energy_error(const std::vector<RunResult>& runs) {
  double worst = 0;
  const auto add = [&](const Estimate& energy) {
    if (energy.value > 1e-3) worst = std::max(worst, energy.standard_error / energy.value);
  };
  for (const RunResult& run : runs)
    for (const SideResult* side : {&run.reflected, &run.transmitted})
      for (int c = 0; c < run.channels; ++c) {
        add(side->total[c]);
        add(side->zero[c]);
        for (const auto& order : side->orders) add(order[c]);
      }
  return worst;
}

ReferenceMethod lobes_by_solver(const std::vector<RunResult>& runs, double tolerance) {
  ReferenceMethod method{.name = runs[0].accuracy->harmonics ? "harmonics" : "adding-doubling",
                         .tolerance = tolerance};
  for (const RunResult& run : runs) method.error = std::max(method.error, run.accuracy->error);
  return method;
}

ReferenceMethod lobes_by_walks(const std::vector<RunResult>& runs, const std::string& reason) {
  ReferenceMethod method{.name = to_text(runs[0].estimator),
                         .reason = reason,
                         .error = worst_energy_error(runs),
                         .walks = runs[0].walks};
  for (const RunResult& run : runs) method.walks = std::min(method.walks, run.walks);
  return method;
}

struct Lobes {
  std::vector<RunResult> runs{};
  ReferenceMethod method{};
  TruthRequest request{};
};

std::vector<RunResult> runs_of(const TruthRequest& request, const RunMonitor& monitor) {
  GroundTruth truth(request, Estimator::analog, monitor);
  std::vector<RunResult> runs;
  for (std::size_t k = 0; truth.goes_on(k); ++k) runs.push_back(truth.find(k).run);
  return runs;
}

Lobes lobes_of(const Stack& stack, const ReferenceEffort& effort, const RunMonitor& monitor) {
  Lobes lobes;
  const TruthRequest open = request_of(stack, effort);
  const double seconds = kLobeShare * effort.seconds;
  std::string reason = why_walks(effort, stack);
  if (reason.empty()) {
    lobes.request = by_solver(open, effort.tolerance, seconds);
    try {
      const TimeLimit limit(seconds, monitor.stop);
      lobes.runs = runs_of(lobes.request, limited(monitor, limit));
      const auto better = why_walks_are_better(lobes.runs, lobes.request);
      if (!better) {
        lobes.method = lobes_by_solver(lobes.runs, effort.tolerance);
        return lobes;
      }
      reason = *better;
    } catch (const NoAnswerError&) {
      reason = kNoAnswer;
    }
  }
  if (monitor.is_stopped()) return lobes;
  lobes.request = by_walks(open, seconds);
  lobes.runs = runs_of(lobes.request, monitor);
  lobes.method = lobes_by_walks(lobes.runs, reason);
  return lobes;
}

PairTruth points_of(const Stack& stack, const ReferenceEffort& effort,
                    const std::vector<DirectionPair>& pairs, const RunMonitor& monitor,
                    std::string& reason) {
  const TruthRequest open = request_of(stack, effort);
  const double seconds = (1 - kLobeShare) * effort.seconds;
  reason = why_walks(effort, stack);
  if (reason.empty()) {
    try {
      const TimeLimit limit(seconds, monitor.stop);
      PairTruth truth = truth_of_pairs(by_solver(open, effort.point_tolerance, seconds), pairs,
                                       limited(monitor, limit));
      if (!has_wide_bounds(truth)) return truth;
      reason = fmt::format("the solver's bounds are above {} of f at most points", kWideBound);
    } catch (const NoAnswerError&) {
      reason = kNoAnswer;
    }
  }
  TruthRequest request = by_walks(open, seconds);
  request.estimator = Estimator::next_event;
  // By pairs the time is that of all directions.
  request.effort.seconds = seconds;
  return truth_of_pairs(request, pairs, monitor);
}

}  // namespace

std::vector<DirectionPair> library_pairs(const Stack& stack) {
  // Off every mirror direction, one of them near grazing.
  constexpr double kAbove[][2] = {{10, 10}, {40, 100}, {65, 170}, {84, 25}};
  constexpr double kBelow[][2] = {{170, 20}, {115, 150}};
  std::vector<DirectionPair> pairs;
  for (const Direction wi : library_directions(stack)) {
    for (const auto& [theta, phi] : kAbove)
      pairs.push_back({wi, direction_from_degrees(theta, phi)});
    if (!stack.is_open_below()) continue;
    for (const auto& [theta, phi] : kBelow)
      pairs.push_back({wi, direction_from_degrees(theta, phi)});
  }
  return pairs;
}

std::optional<Reference> find_reference(const Stack& stack, const ReferenceEffort& effort,
                                        const RunMonitor& monitor, ExrImage* image) {
  RunMonitor quiet = monitor;
  quiet.warning = {};  // what was reached stands in the entry
  Lobes lobes = lobes_of(stack, effort, quiet);
  if (monitor.is_stopped()) return std::nullopt;
  Reference reference;
  reference.lobe_method = lobes.method;
  if (image) *image = simulation_image(lobes.request, lobes.runs);
  const int channels = lobes.runs[0].channels;
  for (const RunResult& run : lobes.runs)
    for (const double energy : missing_energy(run, Order::all))
      reference.unresolved.push_back(energy);
  if (std::all_of(reference.unresolved.begin(), reference.unresolved.end(),
                  [](double energy) { return energy <= 0; }))
    reference.unresolved.clear();
  reference.set = take_lobes(lobes.runs);
  reference.set.attributes = file_attributes(lobes.request, lobes.runs);

  reference.pairs = library_pairs(stack);
  std::string reason;
  const PairTruth points = points_of(stack, effort, reference.pairs, quiet, reason);
  if (monitor.is_stopped()) return std::nullopt;
  reference.f = points.f;
  reference.f_error = points.error;
  ReferenceMethod& method = reference.point_method;
  method = {.name = !points.is_solved()  ? "next-event"
                    : is_harmonic(stack) ? "harmonics"
                                         : "adding-doubling",
            .reason = points.is_solved() ? "" : reason,
            .tolerance = points.is_solved() ? effort.point_tolerance : 0,
            .walks = points.fewest_walks};
  double brightest = 0;
  for (const Rgb& f : points.f) brightest = std::max(brightest, f.max());
  for (std::size_t k = 0; k < points.f.size(); ++k)
    for (int c = 0; c < channels; ++c)
      if (points.f[k][c] > kDarkPoint * brightest)
        method.error = std::max(method.error, points.error[k][c] / points.f[k][c]);
  return reference;
}

}  // namespace lamella
