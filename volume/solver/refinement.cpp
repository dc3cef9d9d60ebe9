// Nodes and modes are refined until the probes' values stand still.

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/partitioner.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "phase/math/larger_error.h"
#include "volume/adding/make_stack_solver.h"
#include "volume/solver/closed_orders.h"
#include "volume/solver/deterministic.h"
#include "volume/solver/deterministic_channel.h"
#include "volume/solver/distinct_channels.h"
#include "volume/solver/mode_tail.h"
#include "volume/solver/second_split.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Both grazing, straight on and near it are among the pairs: the hard places of steep media.
const std::vector<double> kProbesIn{0.01, 0.07, 0.3, 0.6, 0.9};
const std::vector<double> kProbesOut{0.01, 0.02, 0.13, 0.45, 0.6, 0.62, 1.0};

// Of the brightest pair between two sides: where f is fainter, errors are relative to that.
constexpr double kFaint = 1e-8;
constexpr double kDark = 1e-200;  // [1/sr] less is no light

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Whether light may cross a rough interface, be mirrored, and cross it or another one: both narrow
// lobes in turn peak about the normal, next to where the light came from.
bool crosses_facets_twice(const Stack& stack) {
  const auto interfaces = std::count_if(stack.layers.begin(), stack.layers.end(),
                                        [](const Layer& l) { return l.interface.has_value(); });
  const bool metal = stack.substrate && stack.substrate->model == "conductor";
  return stack.has_rough_interfaces() && (interfaces > 1 || metal);
}

// The probes above the stack, and below it where they are other directions there.
std::vector<AskedCosine> probes(const std::vector<double>& cosines, const OuterIndices& outer,
                                bool below) {
  std::vector<AskedCosine> asked;
  for (const double mu : cosines) asked.push_back({mu, outer.above});
  if (below && outer.below != outer.above)
    for (const double mu : cosines) asked.push_back({mu, outer.below});
  return asked;
}

// What the probes see at one number of nodes. second: the part of order 2 that may be integrated
// directly instead; rest: all other orders from 2 up.
struct ProbeModes {
  std::vector<Parts> second, rest;
  Parts mean;                     // over the azimuth, of all orders
  std::array<double, 4> faint{};  // kFaint of the brightest, by part
  double energy_defect = 0;       // DeterministicAccuracy::energy_defect
  bool finite = true;             // all of the above

  // What errors are relative to.
  [[nodiscard]] double scale(int part, Index pair) const {
    return std::max(mean[part](pair), faint[part]);
  }
  // f is no light here, and its digits decide nothing. (What is no number is not dark.)
  [[nodiscard]] bool is_dark(int part, Index pair) const {
    return std::abs(mean[part](pair)) <= kDark;
  }
  // How far f is below 0 on average over the azimuth, relative to the scale.
  [[nodiscard]] double below_zero(int part, Index pair) const {
    return std::max(0.0, -mean[part](pair)) / scale(part, pair);
  }
};

// How far the energies of beams along the probes are from what any stack does to light: their sum
// from 1, and each from 0 where it is negative.
double energy_defect(const AskedMode& mean, bool below) {
  double defect = 0;
  for (const AskedEnergies& side : mean.energies) {
    if (&side == &mean.energies[1] && !below) break;
    for (Index j = 0; j < side.absorbed.size(); ++j) {
      const double reflected = side.reflected[0][j];
      const double transmitted = side.transmitted[0][j];
      const double absorbed = side.absorbed[j];
      const double mirrored = side.mirrored[0].size() > 0 ? side.mirrored[0][j] : 0;
      defect = larger_error(defect, std::abs(reflected + transmitted + absorbed + side.direct[j] +
                                             mirrored + side.lost[j] - 1));
      for (const double energy : {reflected, transmitted, absorbed, side.lost[j]})
        defect = larger_error(defect, -energy);
    }
  }
  return defect;
}

struct Limits {
  double tolerance;
  int max_modes;
  std::size_t max_bytes;
  double seconds;   // left
  int first_batch;  // modes that are worth solving at once, as far as is known
  bool steep;
  bool is_first_closed;
  const std::atomic<bool>* stop;
  std::function<void(int modes)> report;
};

// What the modes left out may add, at the worst probe, but for order 2 of steep media.
double left_out(const ProbeModes& probes, int parts) {
  double worst = 0;
  std::vector<double> modes(probes.rest.size());
  for (int part = 0; part < parts; ++part)
    for (Index p = 0; p < probes.mean[part].size(); ++p) {
      if (probes.is_dark(part, p)) continue;
      for (std::size_t m = 0; m < modes.size(); ++m)
        modes[m] = probes.rest[m][part](p) / probes.scale(part, p);
      worst = larger_error(worst, fit_mode_tail(modes).error);
    }
  return worst;
}

// Stops once four successive modes are below tolerance / 10 at every probe and the estimated tail
// is below tolerance / 2. If the tail falls too slowly for that, stops at twice the number of modes
// at which the first test passed.
ProbeModes solve_probes(StackSolver& stack, SecondSplit* split, int parts, const Limits& limits,
                        DeterministicLimit& ended) {
  const auto start = std::chrono::steady_clock::now();
  ProbeModes result;
  const int threads = std::max(1, oneapi::tbb::this_task_arena::max_concurrency());
  int quiet = 0, first_quiet = 0;
  ended = DeterministicLimit::modes;
  // Modes that are solved at once: more than threads where that is a matter of a moment, so that
  // the clock and `stop` are looked at often, and that nothing waits for mode 0, the longest.
  constexpr double kMoment = 0.1;
  int batch = std::max(threads, limits.first_batch);
  std::vector<AskedMode> solved;
  for (int first = 0, count = 0; first < limits.max_modes; first += count) {
    if (first == stack.ready() && !stack.prepare_more(limits.max_bytes)) {
      ended = DeterministicLimit::memory;
      return result;
    }
    if (first > 0 && seconds_since(start) > limits.seconds) {
      ended = DeterministicLimit::time;
      return result;
    }
    if (first > 0 && limits.stop && *limits.stop) {
      ended = DeterministicLimit::interrupted;
      return result;
    }
    limits.report(first);
    const auto begun = std::chrono::steady_clock::now();
    count = std::min({batch, stack.ready() - first, limits.max_modes - first});
    solved.resize(std::max(solved.size(), static_cast<std::size_t>(count)));
    oneapi::tbb::parallel_for(
        0, count, [&](int k) { solved[k] = stack.asked_mode(first + k); },
        oneapi::tbb::simple_partitioner());
    batch = first == 0 || seconds_since(begun) > kMoment ? threads : 2 * batch;
    if (first == 0) result.energy_defect = energy_defect(solved[0], parts > 1);
    for (int k = 0; k < count; ++k) {
      const int m = first + k;
      Parts rest, second;
      double size = 0;
      const std::optional<Parts> counted = split ? split->counted(m) : std::nullopt;
      for (int part = 0; part < parts; ++part) {
        const auto series = [&](int index) -> const MatrixXd& {
          return solved[k].series[index][part];
        };
        if (m == 0) {
          result.mean[part] = series(0);
          result.finite = result.finite && result.mean[part].allFinite();
          result.faint[part] = std::max(kFaint * result.mean[part].maxCoeff(), kDark);
        }
        rest[part] = limits.is_first_closed ? MatrixXd(series(0) - series(1)) : series(0);
        if (limits.steep) {
          second[part] = counted ? (*counted)[part] : series(2);
          rest[part] -= second[part];
        }
        result.finite =
            result.finite && rest[part].allFinite() && (!limits.steep || second[part].allFinite());
        for (Index i = 0; i < rest[part].size(); ++i)
          size = std::max(size, 2 * std::abs(rest[part](i)) / result.scale(part, i));
      }
      if (!result.finite) {
        ended = DeterministicLimit::numbers;
        return result;
      }
      result.rest.push_back(std::move(rest));
      if (limits.steep) result.second.push_back(std::move(second));
      // Odd and even modes may differ: several small ones in a row end the series.
      quiet = size < limits.tolerance / 10 ? quiet + 1 : 0;
      if (quiet < 4) continue;
      if (first_quiet == 0) first_quiet = m + 1;
      if (m + 1 >= 2 * first_quiet || left_out(result, parts) <= limits.tolerance / 2) {
        ended = DeterministicLimit::none;
        return result;
      }
      quiet = 0;
    }
  }
  return result;
}

// Of 8, 16, 32, ... modes the fewest that are not fewer.
int kernels_for(std::size_t modes) {
  return static_cast<int>(std::max<std::size_t>(8, std::bit_ceil(modes)));
}

// Largest errors over all probes, relative to the scale of f.
struct Errors {
  double nodes = 0;         // of all but order 2 of steep media
  double second_nodes = 0;  // of that order, where few enough of its modes are left out
  double all = 0;
};

// coarse: nothing yet at the first number of nodes, where f itself is the bound of its error.
Errors errors_of(const ProbeModes& coarse, const ProbeModes& fine, int parts, double tolerance) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  if (fine.rest.empty() || !fine.finite || !std::isfinite(fine.energy_defect))
    return {kUnknown, 0, kUnknown};
  if (coarse.rest.empty() || !coarse.finite) return {1, 0, larger_error(1, fine.energy_defect)};
  Errors worst;
  double worst_rest = 0;
  for (int part = 0; part < parts; ++part)
    for (Index p = 0; p < fine.mean[part].size(); ++p) {
      if (fine.is_dark(part, p)) continue;
      const double scale = fine.scale(part, p);
      struct One {
        double nodes = 0, left_out = 0;
      };
      const auto compare = [&](const std::vector<Parts>& a, const std::vector<Parts>& b) {
        One one;
        std::vector<double> modes(b.size());
        for (std::size_t m = 0; m < b.size(); ++m) {
          modes[m] = b[m][part](p) / scale;
          // Modes that only one of the two has belong to the tail.
          if (m < a.size())
            one.nodes += (m == 0 ? 1 : 2) * std::abs(b[m][part](p) - a[m][part](p)) / scale;
        }
        one.left_out = fit_mode_tail(modes).error;
        return one;
      };
      const One rest = compare(coarse.rest, fine.rest);
      worst.nodes = larger_error(worst.nodes, rest.nodes + fine.below_zero(part, p));
      double all = rest.nodes + rest.left_out + fine.below_zero(part, p);
      worst_rest = larger_error(worst_rest, all);
      if (!fine.second.empty()) {
        const One second = compare(coarse.second, fine.second);
        if (second.left_out <= tolerance / 4) {
          worst.second_nodes = larger_error(worst.second_nodes, second.nodes);
          all += second.nodes + second.left_out;
        }
      }
      worst.all = larger_error(worst.all, all);
    }
  if (is_second_integrated(worst.second_nodes, tolerance)) worst.all = worst_rest;
  worst.all = larger_error(worst.all, fine.energy_defect);
  return worst;
}

}  // namespace

DeterministicSolution solve_deterministic(const Stack& stack, const DeterministicOptions& options) {
  if (const auto reason = why_not_deterministic(stack)) throw std::invalid_argument(*reason);
  const auto start = std::chrono::steady_clock::now();
  DeterministicSolution solution;
  solution.stack_ = stack;
  solution.tolerance_ = options.tolerance;
  solution.isa_ = options.isa;
  // Behind a rough boundary no light is a beam, and order 2 is as smooth as order 3.
  solution.steep_ = !stack.has_rough_interfaces() &&
                    std::any_of(stack.layers.begin(), stack.layers.end(),
                                [](const Layer& l) { return !l.interface && is_steep(l.medium); });
  const OuterIndices outer(stack);
  const int parts = stack.is_open_below() ? 4 : 1;
  // Narrow lobes of rough interfaces are missed by the nodes about the normal first.
  std::vector<double> cosines_in = kProbesIn, cosines_out = kProbesOut;
  if (stack.has_rough_interfaces()) cosines_in.push_back(1);
  if (crosses_facets_twice(stack)) {
    cosines_in.push_back(0.97);
    cosines_out.insert(cosines_out.end(), {0.97, 0.98});
  }
  const std::vector<AskedCosine> probes_in = probes(cosines_in, outer, parts > 1),
                                 probes_out = probes(cosines_out, outer, parts > 1);
  const DistinctChannels distinct = distinct_channels(stack);
  solution.channels_ = distinct.channels;
  solution.channel_of_ = distinct.channel_of;
  const std::size_t channels = solution.channels_.size();
  std::vector<ProbeModes> coarse(channels);
  DeterministicAccuracy& accuracy = solution.accuracy_;
  accuracy.error = 1;
  bool is_quick = true;
  for (int nodes = options.min_nodes, step = 0;; ++step) {
    const double begun = seconds_since(start);
    DeterministicAccuracy now;
    std::array<int, 3> mode_counts{};
    std::array<std::array<double, 4>, 3> faint{};
    now.nodes = nodes;
    DeterministicLimit ended = DeterministicLimit::none;
    for (std::size_t k = 0; k < channels; ++k) {
      const int channel = solution.channels_[k];
      const std::unique_ptr<StackSolver> modes = make_stack_solver(
          stack, channel, nodes, probes_out, probes_in, solution.steep_ ? 2 : 1, options.isa);
      std::optional<SecondSplit> split;
      if (solution.steep_) split.emplace(stack, channel, nodes, probes_out, probes_in, options.isa);
      DeterministicLimit this_ended;
      // Modes that vary much faster than the nodes can follow would be noise.
      const int most_kernels = std::min(options.max_modes, 16 * nodes + 24);
      int max_modes = most_kernels;
      if (nodes == options.max_nodes) max_modes = std::min(max_modes, options.last_modes[channel]);
      const Limits limits{options.tolerance,
                          max_modes,
                          options.max_bytes,
                          2 * options.max_seconds - seconds_since(start),
                          is_quick ? static_cast<int>(coarse[k].rest.size()) : 0,
                          solution.steep_,
                          is_first_closed(stack),
                          options.stop,
                          [&](int done) {
                            if (options.report)
                              options.report({.nodes = nodes,
                                              .modes = done,
                                              .error = accuracy.error,
                                              .seconds = seconds_since(start)});
                          }};
      // As many kernels at once as fewer nodes took, rounded up to the steps of prepare_more. Their
      // last digits depend on how many: a run that is repeated has those of the first.
      if (!coarse[k].rest.empty())
        modes->prepare(std::min(most_kernels, kernels_for(coarse[k].rest.size())));
      ProbeModes fine = solve_probes(*modes, split ? &*split : nullptr, parts, limits, this_ended);
      if (this_ended != DeterministicLimit::none) ended = this_ended;
      const Errors errors = errors_of(coarse[k], fine, parts, options.tolerance);
      now.node_error = larger_error(now.node_error, errors.nodes);
      now.second_error = larger_error(now.second_error, errors.second_nodes);
      now.error = larger_error(now.error, errors.all);
      now.energy_defect = std::isfinite(errors.all)
                              ? larger_error(now.energy_defect, fine.energy_defect)
                              : errors.all;
      mode_counts[k] = static_cast<int>(fine.rest.size());
      faint[k] = fine.faint;
      now.modes = std::max(now.modes, mode_counts[k]);
      now.bytes = std::max(now.bytes, modes->bytes());
      coarse[k] = std::move(fine);
    }
    for (int c = 0; c < 3; ++c) now.channel_modes[c] = mode_counts[solution.channel_of_[c]];
    now.reached = now.error <= options.tolerance;
    const double error_before = accuracy.error;
    if (step == 0 || now.error <= error_before) {
      accuracy = now;
      solution.modes_ = mode_counts;
      solution.faint_ = faint;
    }
    const double seconds = seconds_since(start);
    is_quick = seconds - begun < 1;
    const int next = nodes % 3 == 0 ? nodes / 3 * 4 : nodes * 3 / 2;
    const double growth = static_cast<double>(next) / nodes;
    if (now.reached) break;
    // More nodes may cure numbers that are not finite, like any other error.
    if (ended != DeterministicLimit::none && ended != DeterministicLimit::modes &&
        ended != DeterministicLimit::numbers)
      accuracy.limit = ended;
    else if (now.node_error <= options.tolerance / 2 &&
             (now.second_error <= options.tolerance ||
              is_second_integrated(now.second_error, options.tolerance)))
      // More nodes would not help: what is left is the tail of the modes.
      accuracy.limit = DeterministicLimit::modes;
    else if (next > options.max_nodes)
      accuracy.limit = DeterministicLimit::nodes;
    else if (seconds + growth * growth * growth * (seconds - begun) > options.max_seconds)
      accuracy.limit = DeterministicLimit::time;
    else if (static_cast<double>(now.bytes) * growth * growth >
             static_cast<double>(options.max_bytes))
      accuracy.limit = DeterministicLimit::memory;
    if (accuracy.limit != DeterministicLimit::none) break;
    nodes = next;
  }
  if (!std::isfinite(accuracy.error) && accuracy.limit != DeterministicLimit::interrupted)
    accuracy.limit = DeterministicLimit::numbers;
  accuracy.seconds = seconds_since(start);
  return solution;
}

}  // namespace lamella
