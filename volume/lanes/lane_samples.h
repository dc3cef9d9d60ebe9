#pragma once

#include <array>
#include <vector>

#include "volume/lanes/lane_dispatch.h"
#include "volume/lanes/lane_setting.h"
#include "volume/result/walk_samples.h"

namespace lamella {

/// The walks of LaneRun one by one: the same walks, kept instead of counted. For stacks without a
/// reason in why_not_lanes.
class LaneSamples {
 public:
  /// law: with another than `fixed` w_i is drawn by every walk, and `incident` says that it is
  /// above.
  LaneSamples(const Stack& stack, const Plan& plan, Direction incident, IncidentLaw law,
              std::uint64_t seed);

  /// The walks `from` to `to` (not included), in their order; the same in whatever company. `from`
  /// and `to` have the same upper half. Throws NonFiniteError.
  [[nodiscard]] WalkSamples take(std::uint64_t from, std::uint64_t to) const;

 private:
  struct Rows;
  /// The rows of walks whose light left, into columns with room for all; how many there are.
  template <int kChannels>
  [[nodiscard]] std::size_t gather(const Rows& rows, std::size_t walks, WalkSamples& samples) const;
  void walk(std::uint64_t from, std::uint64_t to, const Rows& rows, bool& finite) const;
  [[nodiscard]] std::array<float, 3> weights_after(std::uint32_t order) const;

  LaneSetting<float> setting_;
  Thinning thinning_;
  Direction incident_;
  LaneWalkTask task_;
  LaneLoop loop_;
  std::vector<std::array<float, 3>> weights_;  // by order, of walks without weights
};

}  // namespace lamella
