#include "volume/harmonics/harmonic_pairs.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "phase/math/larger_error.h"
#include "volume/harmonics/bounded_solution.h"
#include "volume/harmonics/harmonic_degrees.h"
#include "volume/harmonics/harmonic_solution.h"
#include "volume/harmonics/mirror_pairs.h"
#include "volume/solver/closed_orders.h"
#include "volume/solver/distinct_channels.h"

namespace lamella {
namespace {

constexpr double kShareOfMirrors = 0.1;  // of the tolerance
constexpr double kSafetyOfChange = 3, kLeastStillAhead = 0.1;
// Pairs through boundaries that one solution serves, at most: each direction has a row in the
// operators of all that lies around the layers.
constexpr std::size_t kMostBounded = 256;

class PairRefinement {
 public:
  PairRefinement(const Stack& stack, std::span<const std::pair<Direction, Direction>> pairs,
                 const HarmonicOptions& options)
      : stack_(stack),
        options_(options),
        is_bounded_(stack.has_boundaries()),
        summed_(is_bounded_ ? std::vector<int>(kSummedParts.begin(), kSummedParts.end())
                            : std::vector<int>{1, 2, kWithoutPairs}),
        mirrors_(stack, options.isa) {
    for (const auto& [wi, wo] : pairs) {
      pairs_.emplace_back(solvable(wi), with_grazing_limit(wo));
      lowest_ = std::min(lowest_, std::abs(pairs_.back().first.z));
    }
    std::vector<Direction> incident;
    for (const auto& pair : pairs_) incident.push_back(pair.first);
    is_even_ = is_even(stack, incident);
    // Pairs of one incident direction share its solution.
    for (std::size_t k = 0; k < pairs_.size(); ++k) order_.push_back(k);
    const auto key = [&](std::size_t k) {
      const Direction w = pairs_[k].first;
      return std::array{w.x, w.y, w.z};
    };
    std::stable_sort(order_.begin(), order_.end(),
                     [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
    DistinctChannels distinct = distinct_channels(stack);
    channels_ = std::move(distinct.channels);
    channel_of_ = distinct.channel_of;
  }

  std::vector<HarmonicPair> run(DeterministicAccuracy& accuracy) {
    const auto start = std::chrono::steady_clock::now();
    const auto seconds = [&] {
      return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    accuracy = {};
    for (std::size_t k = first_degree(stack_); k < std::size(kHarmonicDegrees); ++k) {
      const double before = seconds();
      try {
        solve(kHarmonicDegrees[k], levels_ == 0 ? nullptr : options_.stop);
      } catch (const HarmonicStopped&) {
        accuracy.limit = DeterministicLimit::interrupted;
        break;
      }
      if (levels_ == 1) solve_exact();
      accuracy.harmonics = kHarmonicDegrees[k];
      accuracy.error = accuracy.node_error = judge();
      accuracy.reached = accuracy.error <= options_.tolerance;
      if (options_.report)
        options_.report({.nodes = accuracy.harmonics,
                         .modes = accuracy.harmonics + 1,
                         .error = accuracy.error,
                         .seconds = seconds()});
      if (accuracy.reached) break;
      if (k + 1 == std::size(kHarmonicDegrees) || kHarmonicDegrees[k + 1] > options_.max_degree) {
        accuracy.limit = DeterministicLimit::modes;
        break;
      }
      if (next_bytes(k) > static_cast<double>(options_.max_bytes)) {
        accuracy.limit = DeterministicLimit::memory;
        break;
      }
      const double next = (seconds() - before) * growth(k);
      if (seconds() + next > options_.max_seconds) {
        accuracy.limit = DeterministicLimit::time;
        break;
      }
    }
    accuracy.bytes = bytes_;
    accuracy.nodes = std::max(32, accuracy.harmonics + 8);
    accuracy.modes = accuracy.harmonics + 1;
    accuracy.channel_modes.fill(accuracy.modes);
    accuracy.seconds = seconds();
    std::vector<HarmonicPair> answer(pairs_.size());
    for (std::size_t p = 0; p < pairs_.size(); ++p)
      for (int c = 0; c < 3; ++c) {
        answer[p].f[c] = value(p, c);
        answer[p].error[c] = error(p, c);
      }
    return answer;
  }

 private:
  // By part: now, and one and two steps ago.
  using Parts = std::array<double, kHarmonicParts>;

  [[nodiscard]] HarmonicResolution resolution_at(int degree, const std::atomic<bool>* stop) const {
    HarmonicResolution resolution =
        resolution_of(degree, levels_, lowest_, options_.tolerance, options_.isa, stop);
    resolution.is_even = is_even_;
    return resolution;
  }

  // As in harmonic_runs.
  [[nodiscard]] double next_bytes(std::size_t k) const {
    if (is_bounded_) return static_cast<double>(bytes_) * growth_of_operators(k);
    return static_cast<double>(
        bytes_of_open(stack_, channels_, resolution_at(kHarmonicDegrees[k + 1], nullptr)));
  }

  void solve(int degree, const std::atomic<bool>* stop) {
    std::vector<std::vector<Parts>> next(channels_.size(), std::vector<Parts>(pairs_.size()));
    const HarmonicResolution resolution = resolution_at(degree, stop);
    bytes_ = is_bounded_ ? 0 : bytes_of_open(stack_, channels_, resolution);
    const LayerKernels kernels(HarmonicTransport::basis_of(resolution),
                               MatrixProduct(options_.isa));
    SharedBoundaries boundaries;
    for (std::size_t n = 0; n < channels_.size(); ++n) {
      if (is_bounded_)
        solve_bounded(channels_[n], resolution, kernels, boundaries, next[n]);
      else
        solve_open(channels_[n], resolution, kernels, next[n]);
    }
    before_ = std::move(now_);
    now_ = std::move(next);
    ++levels_;
  }

  void solve_open(int channel, const HarmonicResolution& resolution, const LayerKernels& kernels,
                  std::vector<Parts>& answers) const {
    const HarmonicTransport transport(stack_, channel, resolution, &kernels);
    std::optional<HarmonicSolution> solution;
    Direction solved{};
    for (const std::size_t k : order_) {
      const auto& [wi, wo] = pairs_[k];
      // Nothing leaves through a closed bottom.
      if (wo.z < 0 && !stack_.is_open_below()) continue;
      if (!solution || !(solved == wi)) solution.emplace(transport, wi);
      solved = wi;
      answers[k] = solution->f(wo);
    }
  }

  void solve_bounded(int channel, const HarmonicResolution& resolution, const LayerKernels& kernels,
                     SharedBoundaries& boundaries, std::vector<Parts>& answers) {
    const double bottom = stack_.index_of(stack_.layers.size());
    std::vector<AskedCosine> asked;
    std::vector<Direction> incident;
    for (const std::size_t k : order_) {
      const auto& [wi, wo] = pairs_[k];
      asked.push_back({std::abs(wo.z), wo.z > 0 ? 1 : bottom});
      if (incident.empty() || !(incident.back() == wi)) incident.push_back(wi);
    }
    const BoundedTransport transport(stack_, channel, resolution, asked, incident, &kernels,
                                     &boundaries);
    bytes_ = std::max(bytes_, transport.surroundings().bytes());
    std::optional<BoundedSolution> solution;
    std::size_t beams = 0;
    for (std::size_t place = 0; place < order_.size(); ++place) {
      const auto& [wi, wo] = pairs_[order_[place]];
      if (!solution || !(incident[beams - 1] == wi)) {
        solution.emplace(transport, beams, wi);
        ++beams;
      }
      if (wo.z < 0 && !stack_.is_open_below()) continue;
      const double phi[] = {azimuth(wo)};
      const auto parts = solution->f(wo.z > 0, place, 1, phi);
      for (int part = 0; part < kHarmonicParts; ++part)
        answers[order_[place]][part] = parts[part].size() > 0 ? parts[part](0, 0) : 0;
    }
  }

  void solve_exact() {
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      const auto& [wi, wo] = pairs_[p];
      Exact exact{closed_orders(stack_, wi, wo).all(), 0};
      if (is_bounded_) {
        exact_.push_back(exact);
        continue;
      }
      double least = 1e300;
      for (int c = 0; c < 3; ++c) {
        double sum = exact.f[c];
        for (const int part : {0, 1, 2}) sum += now_[channel_of_[c]][p][part];
        if (sum > 0) least = std::min(least, sum);
      }
      const MirrorPairs::Value twice =
          mirrors_(wi, wo, least < 1e300 ? kShareOfMirrors * options_.tolerance * least : 1e-9);
      exact.f += twice.f;
      exact.error = twice.error;
      exact_.push_back(exact);
    }
  }

  [[nodiscard]] double value(std::size_t p, int c) const {
    double sum = exact_[p].f[c];
    for (const int part : summed_) sum += now_[channel_of_[c]][p][part];
    return sum;
  }
  [[nodiscard]] double changed(std::size_t p, int c, int part) const {
    const int n = channel_of_[c];
    return std::abs(now_[n][p][part] - (before_.empty() ? 0 : before_[n][p][part]));
  }
  [[nodiscard]] double error(std::size_t p, int c) const {
    double sum = exact_[p].error;
    for (const int part : summed_)
      sum += ahead_[part] * std::max(changed(p, c, part), mean_[part] * std::abs(value(p, c)));
    return sum;
  }

  // The worst bound, relative to its value.
  [[nodiscard]] double judge() {
    for (const int part : summed_) {
      const double last = mean_[part];
      double square = 0;
      for (std::size_t p = 0; p < pairs_.size(); ++p)
        for (int c = 0; c < 3; ++c)
          if (value(p, c) > 0) {
            const double relative = changed(p, c, part) / value(p, c);
            square += relative * relative;
          }
      mean_[part] = std::sqrt(square / (3.0 * static_cast<double>(pairs_.size())));
      ahead_[part] = levels_ > 2 && last > 0
                         ? std::clamp(kSafetyOfChange * mean_[part] / last, kLeastStillAhead, 1.0)
                         : 1;
    }
    double worst = 0;
    for (std::size_t p = 0; p < pairs_.size(); ++p)
      for (int c = 0; c < 3; ++c)
        if (value(p, c) != 0) worst = larger_error(worst, error(p, c) / std::abs(value(p, c)));
    return worst;
  }

  struct Exact {
    Rgb f;  // ClosedOrders and, without boundaries, what mirrors scatter twice
    double error;
  };
  const Stack& stack_;
  HarmonicOptions options_;
  bool is_bounded_, is_even_ = false;
  std::vector<int> summed_;  // parts of a solution that count beside what is exact
  MirrorPairs mirrors_;
  std::vector<std::pair<Direction, Direction>> pairs_;
  std::vector<std::size_t> order_;
  double lowest_ = 1;
  std::vector<int> channels_;
  std::array<int, 3> channel_of_{};
  int levels_ = 0;
  std::size_t bytes_ = 0;                         // of the last solution
  std::vector<std::vector<Parts>> now_, before_;  // by distinct channel and pair
  std::vector<Exact> exact_;
  std::array<double, kHarmonicParts> mean_{}, ahead_{};
};

}  // namespace

std::vector<HarmonicPair> harmonic_pairs(const Stack& stack,
                                         std::span<const std::pair<Direction, Direction>> pairs,
                                         const HarmonicOptions& options,
                                         DeterministicAccuracy& accuracy) {
  if (const auto reason = why_not_harmonic(stack)) throw std::invalid_argument(*reason);
  if (pairs.empty()) return {};
  if (!stack.has_boundaries() || pairs.size() <= kMostBounded)
    return PairRefinement(stack, pairs, options).run(accuracy);
  std::vector<HarmonicPair> answers;
  DeterministicAccuracy all;
  all.reached = true;
  for (std::size_t begin = 0; begin < pairs.size(); begin += kMostBounded) {
    HarmonicOptions rest = options;
    rest.max_seconds = std::max(0.0, options.max_seconds - all.seconds);
    const auto some =
        PairRefinement(stack, pairs.subspan(begin, std::min(kMostBounded, pairs.size() - begin)),
                       rest)
            .run(accuracy);
    answers.insert(answers.end(), some.begin(), some.end());
    const double seconds = all.seconds + accuracy.seconds;
    if (begin == 0 || !(accuracy.error <= all.error)) {
      const bool reached = all.reached;
      all = accuracy;
      all.reached = reached;
    }
    all.seconds = seconds;
    all.reached = all.reached && accuracy.reached;
  }
  accuracy = all;
  return answers;
}

}  // namespace lamella
