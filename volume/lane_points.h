#pragma once

// Next-event estimation on lanes. Only for sources of lamella_lanes(). Terms are rounded to
// multiples of 1 / kPointUnits, whose sums are the same in any order.

#include "phase/lane_math.h"
#include "phase/vec3.h"
#include "volume/lane_walk.h"

namespace lamella::LAMELLA_ISA {

/// A float per lane as whole multiples of 1 / kPointUnits, in two halves.
struct FixedPoint {
  using Tag = hn::ScalableTag<std::int64_t>;
  using Vector = hn::Vec<Tag>;
  static constexpr int kHalf = Floats::kCount / 2;
  Vector lower, upper;

  LAMELLA_INLINE explicit FixedPoint(Floats x) {
    const hn::ScalableTag<double> d;
    const hn::Half<Floats::Tag> half;
    // The last place of a double near this number is 2^-32.
    const auto magic = hn::Set(d, 0x1.8p20);
    const auto fix = [&](auto part) {
      return hn::Sub(hn::BitCast(Tag(), hn::Add(hn::PromoteTo(d, part), magic)),
                     hn::BitCast(Tag(), magic));
    };
    lower = fix(hn::LowerHalf(half, x.v));
    upper = fix(hn::UpperHalf(half, x.v));
  }
  LAMELLA_INLINE void add_to(std::int64_t* sums) const {
    hn::StoreU(hn::Add(hn::LoadU(Tag(), sums), lower), Tag(), sums);
    hn::StoreU(hn::Add(hn::LoadU(Tag(), sums + kHalf), upper), Tag(), sums + kHalf);
  }
  [[nodiscard]] LAMELLA_INLINE std::int64_t sum() const {
    const Tag d;
    return hn::GetLane(hn::SumOfLanes(d, hn::Add(lower, upper)));
  }
};

struct NoPoints {
  template <class M, class Event>
  LAMELLA_INLINE void operator()(const M&, const Event&, Floats, Words, FloatMask) {}
};

/// One direction after the other, all lanes at once.
struct FewPoints {
  static constexpr int kMost = 4;
  const LanePoints& points;
  float depth;

  template <class M, class Event>
  LAMELLA_INLINE void operator()(const M& medium, const Event& event, Floats y, Words order,
                                 FloatMask counts) {
    for (int j = 0; j < points.count; ++j) {
      const Vec3<Floats> wo{Floats(points.x[j]), Floats(points.y[j]), Floats(points.z[j])};
      const Floats way = j < points.up ? y : Floats(depth) - y;
      const Floats term = select(
          counts, medium.density(event, wo) * exp(-(way * Floats(points.rate[j]))), Floats(0));
      for (std::uint32_t slot = 0; slot < 4; ++slot) {
        const FloatMask here =
            counts & to_float_mask(slot < 3 ? equal(order, Words(slot + 1)) : order >= Words(4u));
        if (!any(here)) continue;
        points.sums[static_cast<int>(slot) * points.padded + j] +=
            FixedPoint(select(here, term, Floats(0))).sum();
      }
    }
  }
};

/// One event after the other, as many directions at once as there are lanes.
struct ManyPoints {
  const LanePoints& points;
  float depth;

  template <class M, class Event>
  LAMELLA_INLINE void operator()(const M& medium, const Event& event, Floats y, Words order,
                                 FloatMask counts) {
    constexpr int n = Floats::kCount;
    alignas(64) float numbers[Event::kNumbers * n], depths[n];
    alignas(64) std::uint32_t orders[n];
    event.store(numbers);
    y.store(depths);
    order.store(orders);
    for (std::uint32_t left = mask_bits(counts); left != 0; left &= left - 1) {
      const int lane = __builtin_ctz(left);
      const Event one = Event::broadcast_from(numbers, lane);
      const std::uint32_t slot = (orders[lane] < 4 ? orders[lane] : 4) - 1;
      std::int64_t* sums = points.sums + static_cast<int>(slot) * points.padded;
      const Floats above(depths[lane]), below(depth - depths[lane]);
      const Floats up(points.up);
      for (int j = 0; j < points.padded; j += n) {
        const Vec3<Floats> wo{Floats::load(points.x + j), Floats::load(points.y + j),
                              Floats::load(points.z + j)};
        const Floats rate = Floats::load(points.rate + j);
        const Floats way = select(wo.z > Floats(0), above, below);
        const Floats tau = way * rate;
        FixedPoint(medium.density(one, wo) * exp(-tau)).add_to(sums + j);
      }
    }
  }
};

}  // namespace lamella::LAMELLA_ISA
