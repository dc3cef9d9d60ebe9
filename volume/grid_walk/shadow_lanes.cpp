// Ratio tracking of many shadow rays at once: each lane takes a ray from cell to cell of one
// majorant and from one tentative collision to the next.

#include <hwy/highway.h>

#include "phase/random/lane_random.h"
#include "volume/grid_walk/shadow_task.h"

namespace lamella::LAMELLA_ISA {
namespace {

constexpr int kLanes = Floats::kCount;
static_assert(kShadowRays % kLanes == 0);
// A word of a number just below x > 0, and the extinction over a majorant that rounding explains.
constexpr float kJustBelow = 1 - 0x1p-23f, kRounding = 1 + 1e-4f;
// Blocks of random numbers until a ray counts as endless.
constexpr std::uint32_t kMostBlocks = 1u << 26;
// Shares below the first are left to chance, see ratio_tracked.
constexpr float kLittle = 0.1f, kInverseChance = 4;

// What a ray carries from one block of random numbers to the next, one array for each number.
enum Number { kPlace, kSpeed = 3, kFrom = 6, kScale = 9, kBound, kShare, kLittleShare, kNumbers };
enum Name { kRay, kOrdinal, kLow, kHigh, kNames };
struct Rays {
  // A register may be stored where the last ray begins.
  float numbers[kNumbers][kShadowRays + kLanes];
  std::uint32_t names[kNames][kShadowRays + kLanes];
};

struct Axis {
  Floats place, speed, inverse, end;  // end: of the tile, in voxels
  Words last;                         // the last voxel
  FloatMask up;
};

// A cell's extent along an axis.
struct Side {
  Floats low, high;
  Words low_voxel, high_voxel;  // high: not included
  FloatMask spans;              // the whole tile
  Floats exit;                  // length of the way to it [mm]
};

class Packet {
 public:
  LAMELLA_INLINE Packet(const ShadowTask& t, const Rays& rays, int first, int count)
      : t_(t),
        scale_(Floats::load(rays.numbers[kScale] + first)),
        bound_(Floats::load(rays.numbers[kBound] + first)),
        share_(Floats::load(rays.numbers[kShare] + first)),
        little_(Floats::load(rays.numbers[kLittleShare] + first)),
        began_(first_lanes<float>(count - first < kLanes ? count - first : kLanes)),
        alive_(began_),
        too_low_(began_ ^ began_) {
    for (int a = 0; a < 3; ++a) {
      Axis& x = axis_[a];
      x.place = Floats::load(rays.numbers[kPlace + a] + first);
      x.speed = Floats::load(rays.numbers[kSpeed + a] + first);
      x.inverse = Floats(1) / x.speed;
      x.end = Floats(static_cast<float>(t.voxels[a]));
      x.last = Words(t.voxels[a] - 1);
      x.up = x.speed > Floats(0);
      from_[a] = Floats::load(rays.numbers[kFrom + a] + first);
    }
    for (int k = 0; k < kNames; ++k) names_[k] = Words::load(rays.names[k] + first);
  }

  [[nodiscard]] LAMELLA_INLINE bool too_low() const { return any(too_low_); }
  [[nodiscard]] LAMELLA_INLINE Words name(int k) const { return names_[k]; }
  // The shares of the rays that ended go to `shares`, the others behind the first `count` rays;
  // returns how many there are then.
  LAMELLA_INLINE int store(float* shares, Rays& rays, int count) const {
    const FloatMask ended = without(began_, alive_);
    std::uint32_t which[kLanes];
    float share[kLanes];
    store_compressed(names_[kRay], ended, which);
    store_compressed(share_, ended, share);
    const int n = lamella::LAMELLA_ISA::count(ended);
    for (int k = 0; k < n; ++k) shares[which[k]] = share[k];
    const auto keep = [&](Floats x, int number) LAMELLA_INLINE_LAMBDA {
      store_compressed(x, alive_, rays.numbers[number] + count);
    };
    for (int a = 0; a < 3; ++a) {
      keep(axis_[a].place, kPlace + a);
      keep(axis_[a].speed, kSpeed + a);
      keep(from_[a], kFrom + a);
    }
    keep(scale_, kScale);
    keep(bound_, kBound);
    keep(share_, kShare);
    keep(little_, kLittleShare);
    for (int k = 0; k < kNames; ++k) store_compressed(names_[k], alive_, rays.names[k] + count);
    return count + lamella::LAMELLA_ISA::count(alive_);
  }

  // To the next tentative collision or out of the cell; `chance`: two random bits.
  LAMELLA_INLINE void step(Words bits, Words chance) {
    const Words block =
        block_of(shift_right<3>(voxel(0)), shift_right<3>(voxel(1)), shift_right<3>(voxel(2)));
    const auto cell = gather_pair(t_.block_entries, block);
    const Words edge = bits_of(cell.second);
    Side side[3];
    for (int a = 0; a < 3; ++a) side[a] = side_of(a, edge);
    const Floats exit = min(side[0].exit, min(side[1].exit, side[2].exit));
    const Floats majorant = cell.first * bound_;
    // Empty cells have no collisions: infinity.
    const Floats free = exponential_of(bits) / majorant;
    const FloatMask collides = free < exit;
    const Floats way = min(free, exit);
    for (int a = 0; a < 3; ++a) go_on(a, side[a], way);
    collide(collides, side, majorant, chance);
    leave(!collides, side, exit);
  }

 private:
  [[nodiscard]] LAMELLA_INLINE Words voxel(int a) const {
    return hn::Min(to_words(axis_[a].place).v, axis_[a].last.v);
  }
  // Where the block's entry is.
  [[nodiscard]] LAMELLA_INLINE Words block_of(Words x, Words y, Words z) const {
    return shift_left<2>((z * Words(t_.blocks[1]) + y) * Words(t_.blocks[0]) + x);
  }
  [[nodiscard]] LAMELLA_INLINE Side side_of(int a, Words edge) const {
    const Axis& x = axis_[a];
    Side s;
    s.low_voxel = hn::AndNot(edge.v, voxel(a).v);
    s.high_voxel = hn::Min((s.low_voxel + edge + Words(1u)).v, (x.last + Words(1u)).v);
    s.low = to_floats(s.low_voxel);
    s.high = to_floats(s.high_voxel);
    s.exit = nonnegative((select(x.up, s.high, s.low) - x.place) * x.inverse);
    if (a < 2) {
      s.spans = equal(s.low, Floats(0)) & equal(s.high, x.end);
      s.exit = select(s.spans, Floats(1e30f), s.exit);
    }
    return s;
  }
  // Along an axis, within the cell; a cell as wide as the tile is entered again.
  LAMELLA_INLINE void go_on(int a, const Side& s, Floats way) {
    Floats to = multiply_add(way, axis_[a].speed, axis_[a].place);
    if (a < 2) to = select(s.spans, to - axis_[a].end * floor(to * reciprocal(axis_[a].end)), to);
    axis_[a].place = max(s.low, min(to, s.high * Floats(kJustBelow)));
  }
  LAMELLA_INLINE void collide(FloatMask collides, const Side (&side)[3], Floats majorant,
                              Words chance) {
    Words at[3];
    for (int a = 0; a < 3; ++a)
      at[a] = hn::Min(to_words(axis_[a].place).v, (side[a].high_voxel - Words(1u)).v);
    const Words block =
        block_of(shift_right<3>(at[0]), shift_right<3>(at[1]), shift_right<3>(at[2]));
    const auto content = gather_pair(t_.block_entries + 2, block);
    const Words seven(7u);
    const Words local =
        shift_left<6>(at[2] & seven) + shift_left<3>(at[1] & seven) + (at[0] & seven);
    const Words record = bits_of(content.first) + (local & bits_of(content.second));
    Floats extinction;
    if (t_.turned) {
      const Words place = shift_left<2>(record);
      const auto p = gather_pair(t_.records, place), q = gather_pair(t_.records + 2, place);
      const Floats c =
          multiply_add(p.second, from_[0], multiply_add(q.first, from_[1], q.second * from_[2]));
      extinction = scale_ * sqrt(nonnegative(multiply_add(Floats(t_.sign) * c, c, p.first)));
    } else {
      extinction = scale_ * gather(t_.records, record);
    }
    const FloatMask counts = collides & alive_;
    too_low_ = too_low_ | (counts & (extinction > majorant * Floats(kRounding)));
    const Floats kept = nonnegative(Floats(1) - extinction / majorant);
    share_ = select(counts, share_ * kept, share_);
    // Russian roulette.
    const FloatMask low = share_ < little_;
    const FloatMask lives = to_float_mask(equal(chance & Words(3u), Words(0u)));
    share_ = select(low, select(lives, share_ * Floats(kInverseChance), Floats(0)), share_);
    little_ = select(low, little_ * Floats(kLittle), little_);
    alive_ = alive_ & (share_ > Floats(0));
  }
  // Into the next cell, over the side that comes first.
  LAMELLA_INLINE void leave(FloatMask leaves, const Side (&side)[3], Floats exit) {
    FloatMask rest = leaves;
    for (int a = 0; a < 3; ++a) {
      Axis& x = axis_[a];
      const FloatMask here = rest & (side[a].exit <= exit);
      rest = without(rest, here);
      const FloatMask at_top = equal(side[a].high, x.end),
                      at_bottom = equal(side[a].low, Floats(0));
      if (a == 2) {
        alive_ = without(alive_, here & ((x.up & at_top) | without(at_bottom, x.up)));
      }
      const Floats above = select(at_top, Floats(0), side[a].high);
      const Floats below = select(at_bottom, x.end, side[a].low) * Floats(kJustBelow);
      x.place = select(here, select(x.up, above, below), x.place);
    }
  }

  const ShadowTask& t_;
  Axis axis_[3];
  Floats from_[3], scale_, bound_, share_, little_;
  Words names_[kNames];
  FloatMask began_, alive_, too_low_;
};

void begin(const ShadowTask& t, Rays& rays) {
  for (int first = 0; first < t.count; first += kLanes) {
    const auto put = [&](Floats x, int number)
                         LAMELLA_INLINE_LAMBDA { x.store(rays.numbers[number] + first); };
    for (int a = 0; a < 3; ++a) {
      put(Floats::load(t.place[a] + first), kPlace + a);
      // Never level with an axis: a way of 1e12 mm per voxel leaves by another one.
      const Floats speed = Floats::load(t.speed[a] + first);
      put(copysign(max(abs(speed), Floats(1e-12f)), speed), kSpeed + a);
      put(Floats::load(t.from[a] + first), kFrom + a);
    }
    put(Floats::load(t.scale + first), kScale);
    put(Floats::load(t.bound + first), kBound);
    put(Floats(1), kShare);
    put(Floats(kLittle), kLittleShare);
    (Words::iota() + Words(static_cast<std::uint32_t>(first))).store(rays.names[kRay] + first);
    Words::load(t.ordinal + first).store(rays.names[kOrdinal] + first);
    Words::load(t.walk_low + first).store(rays.names[kLow] + first);
    Words::load(t.walk_high + first).store(rays.names[kHigh] + first);
  }
}

}  // namespace

// Rays take three steps by each block of random numbers; those that go on are moved together then.
ShadowEnd follow_shadow_rays(const ShadowTask& t) {
  Rays rays;
  begin(t, rays);
  int count = t.count;
  for (std::uint32_t block = 0; count > 0; ++block) {
    if (block == kMostBlocks) return ShadowEnd::endless;
    int left = 0;
    for (int first = 0; first < count; first += kLanes) {
      Packet packet(t, rays, first, count);
      const WordBlock r = philox(Words(block), packet.name(kOrdinal), packet.name(kLow),
                                 packet.name(kHigh), t.key_low, t.key_high);
      packet.step(r.w[0], r.w[3]);
      packet.step(r.w[1], shift_right<8>(r.w[3]));
      packet.step(r.w[2], shift_right<16>(r.w[3]));
      if (packet.too_low()) return ShadowEnd::majorant_too_low;
      left = packet.store(t.share, rays, left);
    }
    count = left;
  }
  return ShadowEnd::done;
}

}  // namespace lamella::LAMELLA_ISA
