// Ratio tracking of many shadow rays at once: each lane takes a ray from cell to cell of one
// majorant and from one tentative collision to the next.

#include "phase/random/lane_random.h"
#include "volume/grid_walk/lane_march.h"
#include "volume/grid_walk/shadow_task.h"

namespace lamella::LAMELLA_ISA {
namespace {

constexpr int kLanes = Floats::kCount;
static_assert(kShadowRays % kLanes == 0);
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

class Packet {
 public:
  LAMELLA_INLINE Packet(const ShadowTask& t, const Rays& rays, int first, int count)
      : march_(t.grid,
               {number(rays, kPlace, first), number(rays, kPlace + 1, first),
                number(rays, kPlace + 2, first)},
               {number(rays, kSpeed, first), number(rays, kSpeed + 1, first),
                number(rays, kSpeed + 2, first)}),
        from_{number(rays, kFrom, first), number(rays, kFrom + 1, first),
              number(rays, kFrom + 2, first)},
        scale_(number(rays, kScale, first)),
        bound_(number(rays, kBound, first)),
        share_(number(rays, kShare, first)),
        little_(number(rays, kLittleShare, first)),
        began_(first_lanes<float>(count - first < kLanes ? count - first : kLanes)),
        alive_(began_),
        too_low_(began_ ^ began_) {
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
      keep(march_.place(a), kPlace + a);
      keep(march_.speed(a), kSpeed + a);
    }
    keep(from_.x, kFrom);
    keep(from_.y, kFrom + 1);
    keep(from_.z, kFrom + 2);
    keep(scale_, kScale);
    keep(bound_, kBound);
    keep(share_, kShare);
    keep(little_, kLittleShare);
    for (int k = 0; k < kNames; ++k) store_compressed(names_[k], alive_, rays.names[k] + count);
    return count + lamella::LAMELLA_ISA::count(alive_);
  }

  // To the next tentative collision or out of the cell; `chance`: two random bits.
  LAMELLA_INLINE void step(Words bits, Words chance) {
    const auto cell = march_.cell();
    const Floats majorant = cell.density * bound_;
    // Empty cells have no collisions: infinity.
    const Floats free = exponential_of(bits) / majorant;
    const FloatMask collides = free < cell.exit;
    march_.go_on(cell, min(free, cell.exit));
    collide(collides, majorant, chance);
    alive_ = without(alive_, march_.leave(!collides, cell));
  }

 private:
  [[nodiscard]] LAMELLA_INLINE static Floats number(const Rays& rays, int number, int first) {
    return Floats::load(rays.numbers[number] + first);
  }
  LAMELLA_INLINE void collide(FloatMask collides, Floats majorant, Words chance) {
    const Floats extinction = scale_ * march_.thickness(march_.content(), from_);
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

  LaneMarch march_;
  Vec3<Floats> from_;
  Floats scale_, bound_, share_, little_;
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
