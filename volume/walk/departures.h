#pragma once

#include <functional>

#include "volume/result/walk_samples.h"
#include "volume/walk/scorers.h"

namespace lamella {

/// Follows the walk of that number with light from w_i to its end, and adds what leaves to the
/// samples.
using FollowWalk = std::function<void(Direction wi, std::uint64_t walk, WalkSamples& to)>;

/// Scorer of walks in double that keeps what leaves the stack, deltas too, and nothing else.
class DepartureScorer : public NullScorer {
 public:
  DepartureScorer(Direction wi, WalkSamples& to) : wi_(wi), to_(to) {}

  /// delta: it met nothing, or deltas alone.
  template <std::size_t C>
  void departs(Direction wo, const std::array<double, C>& weight, std::uint64_t order, bool delta) {
    std::array<float, C> weights;
    for (std::size_t c = 0; c < C; ++c) weights[c] = static_cast<float>(weight[c]);
    to_.add(wi_, wo, weights.data(), order, wo.z > 0, delta);
  }

 private:
  Direction wi_;
  WalkSamples& to_;
};

}  // namespace lamella
