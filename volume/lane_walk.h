#pragma once

#include <cstdint>

#include "phase/isa.h"

namespace lamella {

/// Streams of a walk on lanes, beside those of StreamPurpose: up to its first collision, and a
/// block per event from there.
inline constexpr std::uint32_t kLaneStartStream = 4, kLaneWalkStream = 5;

/// What became of a walk, in LaneWalkTask::ends.
enum class WalkEnd : std::uint32_t { up = 0, down = 1, absorbed = 2, unresolved = 3 };
inline constexpr int kWalkEnds = 4;

/// The media that have a kernel on lanes.
enum class LaneMediumKind {
  lambert_sphere,
  henyey_greenstein,
  sggx_mirror,
  sggx_lambert,
  vmf_mirror,
  vmf_lambert
};

/// A medium's numbers, rounded from double.
struct LaneMediumNumbers {
  LaneMediumKind kind{};
  float g = 0;                          ///< henyey_greenstein
  float a[6] = {};                      ///< SGGX: A of S = A A^T: a00 a10 a11 a20 a21 a22
  float inverse[6] = {};                ///< A^-1 likewise
  float density_scale = 0;              ///< SGGX: 1 / (4 pi det A)
  float axis[3] = {};                   ///< vMF: mean normal
  float front = 0, back = 0, side = 0;  ///< vMF: sigma(1), sigma(-1), sigma(0)
  const float* marginals = nullptr;     ///< vMF: see vmf_marginals
};

/// Targets of next-event estimation, structure of arrays; `padded` is `count` rounded up to a
/// multiple of 16, places beyond `count` repeat a valid target.
struct LanePoints {
  int count = 0, padded = 0, up = 0;
  const float *x = nullptr, *y = nullptr, *z = nullptr;
  const float* rate = nullptr;  ///< sigma(-w_o) / |mu_o|
  /// Sums over events of p(w_i -> w_o) exp(-tau), in units of 1 / kPointUnits: [slot][padded].
  std::int64_t* sums = nullptr;
};
/// Fixed point makes sums independent of their order. A term is rounded to 2^-32.
inline constexpr double kPointUnits = 0x1p32;
/// The largest term that fixed point takes.
inline constexpr double kPointLimit = 0x1p18;

/// Where leaving light is counted; see CellGrid.
struct LaneCells {
  bool on = false, folded = false, both_sides = false;
  int rows = 0, columns = 0, phi_cells = 0;
  float azimuth_turns = 0;  ///< of w_i, as a fraction of a turn
  /// Counts [slot][target], and one place more for what is not counted.
  std::uint64_t* counts = nullptr;
};

/// Up to this chance of a first collision it is forced (the series for it is 1e-7 off there).
inline constexpr double kForcedChance = 0.05;

/// Walks of one batch through one homogeneous layer at one albedo. Walk j of `walks` has the index
/// (index_high, index_low + j index_stride), which does not overflow.
struct LaneWalkTask {
  LaneMediumNumbers medium;
  float depth = 0;  ///< infinity for a half space
  float wi[3] = {};
  bool from_above = true;
  float first_flight = 0;  ///< |mu_i| / sigma(w_i): depth per unit of the exponential number
  /// Above 0: every walk collides, its first flight within the layer; this is the chance of that,
  /// at most kForcedChance.
  float forced_chance = 0;
  /// 1 / -log(albedo), infinity at albedo 1: from the fourth event on a walk survives with the
  /// albedo.
  float orders_per_absorption = 0;
  bool black = false;  ///< albedo 0: the first event ends a walk
  std::uint32_t max_order = 0;
  std::uint64_t seed = 0;
  std::uint32_t index_high = 0, index_low = 0, index_stride = 0;
  std::uint32_t walks = 0;
  /// Counts [WalkEnd][order], orders from order_cap on together.
  std::uint64_t* ends = nullptr;
  std::uint32_t order_cap = 0;
  LaneCells cells;
  LanePoints points;
  /// Steps taken times lanes, and how many of these lanes were at a collision of a walk.
  std::uint64_t *lane_steps = nullptr, *busy_lane_steps = nullptr;
  /// Set to 1 + the index of a walk that met a number that is not finite.
  std::uint64_t* bad_walk = nullptr;
};

/// Cubics of each of the four tables of vmf_marginals (volume/lane_marginals.h).
inline constexpr int kMarginalPieces = 256;

LAMELLA_LANE_FUNCTION(void, walk_lanes, (const LaneWalkTask& task))

}  // namespace lamella
