#pragma once

// Straight ways of many walks or rays through a density grid, a lane each: from cell to cell of one
// majorant, as GridMarch goes. Only for sources of lamella_lanes().

#include <hwy/highway.h>

#include "phase/lanes/lane_math.h"
#include "phase/math/vec3.h"
#include "volume/grid_walk/lane_grid.h"

namespace lamella::LAMELLA_ISA {

// A word of a number just below x > 0, and the extinction over a majorant that rounding explains.
inline constexpr float kJustBelow = 1 - 0x1p-23f, kRounding = 1 + 1e-4f;

/// What a voxel holds: its density, or of turned flakes the four numbers of its record.
struct LaneVoxel {
  Floats first;  ///< rho; turned: rho^2 across^2
  Vec3<Floats> v;
};

/// The voxel of a place along an axis.
LAMELLA_INLINE Words voxel_at(const LaneGrid& grid, int axis, Floats place) {
  return hn::Min(to_words(place).v, Words(grid.voxels[axis] - 1).v);
}
/// Where the entry of a voxel's block is.
LAMELLA_INLINE Words block_entry(const LaneGrid& grid, Words x, Words y, Words z) {
  return shift_left<2>((shift_right<3>(z) * Words(grid.blocks[1]) + shift_right<3>(y)) *
                           Words(grid.blocks[0]) +
                       shift_right<3>(x));
}
/// The voxel at a place.
LAMELLA_INLINE LaneVoxel content_at(const LaneGrid& grid, const Floats (&place)[3]) {
  Words at[3];
  for (int a = 0; a < 3; ++a) at[a] = voxel_at(grid, a, place[a]);
  const auto content = gather_pair(grid.block_entries + 2, block_entry(grid, at[0], at[1], at[2]));
  const Words seven(7u);
  const Words local = shift_left<6>(at[2] & seven) + shift_left<3>(at[1] & seven) + (at[0] & seven);
  const Words record = bits_of(content.first) + (local & bits_of(content.second));
  if (!grid.turned) {
    const Floats rho = gather(grid.records, record);
    return {rho, {rho, rho, rho}};
  }
  const Words place4 = shift_left<2>(record);
  const auto p = gather_pair(grid.records, place4), q = gather_pair(grid.records + 2, place4);
  return {p.first, {p.second, q.first, q.second}};
}

class LaneMarch {
 public:
  /// A cell's extent along an axis.
  struct Side {
    Floats low, high;
    FloatMask spans;  // the whole tile
    Floats exit;      // length of the way to it [mm]
  };
  /// The cell that a lane is in.
  struct Cell {
    Side side[3];
    Floats density;  ///< largest of its voxels
    Floats exit;     ///< length of the way out [mm]
  };

  /// place: in voxels, within the tile; speed: in voxels per mm, not 0.
  LAMELLA_INLINE LaneMarch(const LaneGrid& grid, const Floats (&place)[3], const Floats (&speed)[3])
      : grid_(grid) {
    for (int a = 0; a < 3; ++a) {
      Axis& x = axis_[a];
      x.place = place[a];
      x.speed = speed[a];
      x.inverse = Floats(1) / x.speed;
      x.end = Floats(static_cast<float>(grid.voxels[a]));
      x.up = x.speed > Floats(0);
    }
  }

  [[nodiscard]] LAMELLA_INLINE Floats place(int a) const { return axis_[a].place; }
  [[nodiscard]] LAMELLA_INLINE Floats speed(int a) const { return axis_[a].speed; }
  [[nodiscard]] LAMELLA_INLINE FloatMask goes_up() const { return axis_[2].up; }

  [[nodiscard]] LAMELLA_INLINE Cell cell() const {
    const auto entry =
        gather_pair(grid_.block_entries, block_entry(grid_, voxel(0), voxel(1), voxel(2)));
    const Words edge = bits_of(entry.second);
    Cell cell;
    for (int a = 0; a < 3; ++a) cell.side[a] = side_of(a, edge);
    cell.density = entry.first;
    cell.exit = min(cell.side[0].exit, min(cell.side[1].exit, cell.side[2].exit));
    return cell;
  }

  /// On by `way` <= exit within the cell; a cell as wide as the tile is entered again.
  LAMELLA_INLINE void go_on(const Cell& cell, Floats way) {
    for (int a = 0; a < 3; ++a) {
      const Side& s = cell.side[a];
      Floats to = multiply_add(way, axis_[a].speed, axis_[a].place);
      if (a < 2) to = select(s.spans, to - axis_[a].end * floor(to * reciprocal(axis_[a].end)), to);
      axis_[a].place = max(s.low, min(to, s.high * Floats(kJustBelow)));
    }
  }

  /// Into the next cell over the side that comes first, where lanes `leave` this one. Which of them
  /// are out of the grid, above or below.
  LAMELLA_INLINE FloatMask leave(FloatMask leaves, const Cell& cell) {
    FloatMask rest = leaves, out = leaves ^ leaves;
    for (int a = 0; a < 3; ++a) {
      Axis& x = axis_[a];
      const Side& s = cell.side[a];
      const FloatMask here = rest & (s.exit <= cell.exit);
      rest = without(rest, here);
      const FloatMask at_top = equal(s.high, x.end), at_bottom = equal(s.low, Floats(0));
      if (a == 2) out = here & ((x.up & at_top) | without(at_bottom, x.up));
      const Floats above = select(at_top, Floats(0), s.high);
      const Floats below = select(at_bottom, x.end, s.low) * Floats(kJustBelow);
      x.place = select(here, select(x.up, above, below), x.place);
    }
    return out;
  }

  /// The voxel that a lane is in.
  [[nodiscard]] LAMELLA_INLINE LaneVoxel content() const {
    return content_at(grid_, {axis_[0].place, axis_[1].place, axis_[2].place});
  }
  /// Its density, or rho sigma(w) of turned flakes.
  [[nodiscard]] LAMELLA_INLINE Floats thickness(const LaneVoxel& voxel, Vec3<Floats> w) const {
    if (!grid_.turned) return voxel.first;
    const Floats c = multiply_add(voxel.v.x, w.x, multiply_add(voxel.v.y, w.y, voxel.v.z * w.z));
    return sqrt(nonnegative(multiply_add(Floats(grid_.sign) * c, c, voxel.first)));
  }

 private:
  struct Axis {
    Floats place, speed, inverse, end;  // end: of the tile, in voxels
    FloatMask up;
  };

  [[nodiscard]] LAMELLA_INLINE Words voxel(int a) const {
    return voxel_at(grid_, a, axis_[a].place);
  }
  [[nodiscard]] LAMELLA_INLINE Side side_of(int a, Words edge) const {
    const Axis& x = axis_[a];
    Side s;
    const Words low = hn::AndNot(edge.v, voxel(a).v);
    s.low = to_floats(low);
    s.high = to_floats(hn::Min((low + edge + Words(1u)).v, Words(grid_.voxels[a]).v));
    s.exit = nonnegative((select(x.up, s.high, s.low) - x.place) * x.inverse);
    if (a < 2) {
      s.spans = equal(s.low, Floats(0)) & equal(s.high, x.end);
      s.exit = select(s.spans, Floats(1e30f), s.exit);
    }
    return s;
  }
  const LaneGrid& grid_;
  Axis axis_[3];
};

}  // namespace lamella::LAMELLA_ISA
