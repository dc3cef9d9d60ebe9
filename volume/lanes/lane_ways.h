#pragma once

#include <tbb/cache_aligned_allocator.h>

#include <cstdint>
#include <vector>

#include "volume/interfaces/exit_paths.h"
#include "volume/lanes/lane_setting.h"
#include "volume/lanes/lane_way_block.h"
#include "volume/walk/scorers.h"

namespace lamella {

/// Ways out of a stack with interfaces (ExitPaths) as walks on lanes take them: every kWalksPerSet
/// walks of a batch share a set of ways to all targets. Where no way is random, one set serves all.
class WayTables {
 public:
  /// To points with mu != 0, those that go up first.
  WayTables(const Stack& stack, const Plan& plan, Direction incident, std::uint64_t seed,
            int batches, const std::vector<Direction>& points);
  /// To directions within cells, drawn anew for every set.
  WayTables(const Stack& stack, const Plan& plan, std::uint64_t seed, int batches,
            const CellTargets& cells);

  struct Set {
    LaneWays ways;
    std::vector<LaneWayBlock, tbb::cache_aligned_allocator<LaneWayBlock>> blocks;
    std::vector<std::int32_t> first_targets;  ///< of each block
    /// Points: what light that has met no event sends to each of them on average, f of order 0.
    std::vector<double> zero;
  };
  /// Of the walks k kWalksPerSet, k kWalksPerSet + 1, ... of a batch.
  [[nodiscard]] Set set(int batch, std::uint64_t k) const;

  [[nodiscard]] bool is_random() const { return random_; }
  [[nodiscard]] int targets() const { return targets_; }
  /// Where the parts of the stack's layers lie.
  [[nodiscard]] const LaneWayPlaces& places() const { return places_; }

  static constexpr std::uint64_t kWalksPerSet = std::uint64_t{1} << kWaysShift;

 private:
  struct Arrival {
    int boundary;
    Direction wi;
    double weight;
  };
  WayTables(const Stack& stack, const Plan& plan, std::uint64_t seed, int batches);
  void find_arrivals(Direction incident);
  void add_segments(const ExitPaths::Segments& segments, bool at_substrate, double depth,
                    Set& set) const;
  void add_zero(const ExitPaths& paths, Set& set) const;

  BoundaryStack stack_;
  std::uint64_t seed_;
  int batches_;
  int targets_ = 0;
  std::vector<double> x_, y_, z_;  ///< of points
  const CellTargets* cells_ = nullptr;
  LaneWayPlaces places_;
  /// Where light that has met smooth interfaces alone meets the first rough one.
  std::vector<Arrival> arrivals_;
  bool random_ = false;
  bool has_events_ = false;  ///< there is a medium, or a substrate
};

/// Directions in a layer this close to grazing, |mu|, are turned away from it where chance chose
/// them; where Snell's law alone gives them lanes refuse (why_not_lanes_at).
inline constexpr double kMostGrazingWay = 1e-4;

/// The largest 1 / |mu| times `through` of any way through a stack of these indices.
[[nodiscard]] double largest_way(const Stack& stack, const Plan& plan);

/// Whether Snell's law leads light that leaves along w_o through some layer closer to grazing than
/// kMostGrazingWay.
[[nodiscard]] bool grazes_inside(const Stack& stack, const Plan& plan, Direction wo);

}  // namespace lamella
