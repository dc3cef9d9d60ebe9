// Next-event estimation on lanes through interfaces: every event sends its light along the ways of
// one set (WayTables).

#include "volume/lanes/lane_bounded_loop.h"
#include "volume/lanes/lane_next_event.h"

namespace lamella::LAMELLA_ISA {
namespace {

struct NextEventAlongWays : NextEventOnLanes<3> {
  using State = LaneState<Floats, 3>;

  template <class All, class M>
  LAMELLA_INLINE void operator()(All, const M& medium, const LaneEvent<Floats>& event,
                                 const State& w, FloatMask scatters) const {
    const FloatMask counts = scatters & to_float_mask(is_below(w.order, Words(t.walk.max_order)));
    if (any(counts)) along_ways(medium, event, w, counts);
  }

 private:
  // By value: what a call takes the address of does not stay in registers.
  template <class M>
  [[gnu::noinline]] void along_ways(M medium, LaneEvent<Floats> event, State w,
                                    FloatMask counts) const {
    constexpr bool kSubstrate = M::kKind == LaneMediumKind::substrate;
    const StoredEvents stored(medium, event);
    alignas(64) float depths[kLanes], shares[3][kLanes];
    alignas(64) std::uint32_t orders[kLanes], layers[kLanes], indices[kLanes];
    w.y.store(depths);
    w.order.store(orders);
    w.layer.store(layers);
    w.index.store(indices);
    for (int c = 0; c < t.channels; ++c) share(medium, w, c).store(shares[c]);
    for (std::uint32_t left = mask_bits(counts); left != 0; left &= left - 1) {
      const int lane = __builtin_ctz(left);
      const int part = kSubstrate ? t.walk.layer_count : static_cast<int>(layers[lane]);
      const LaneBatch& batch = t.batches[t.batch_of(indices[lane])];
      const LaneWays* ways = batch.ways;
      if (!t.same_ways) {
        const std::uint32_t walk = (indices[lane] - batch.index_low) / t.index_stride;
        ways += (walk + batch.walks_before) >> kWaysShift;
      }
      const std::uint32_t slot =
          orders[lane] + 1 < kRouletteOrder ? orders[lane] : kRouletteOrder - 1;
      const M at = [&]() LAMELLA_INLINE_LAMBDA {
        if constexpr (kSubstrate)
          return medium;
        else
          return M(OneLayer<Floats>{*t.walk.layers, part});
      }();
      send_along(
          Sender<M>{*this,
                    at,
                    stored.of(lane),
                    part,
                    batch.sums->targets + static_cast<int>(slot) * t.channels * t.way_targets,
                    {Floats(shares[0][lane]), Floats(shares[1][lane]), Floats(shares[2][lane])}},
          *ways, depths[lane]);
    }
  }

  template <class M>
  LAMELLA_INLINE void send_along(const Sender<M>& sender, const LaneWays& ways, float y) const {
    constexpr bool kSubstrate = M::kKind == LaneMediumKind::substrate;
    const LaneWayPlaces& places = t.way_places;
    const int layer = places.layer[sender.layer];
    const float above = places.above[sender.layer] + y;
    const Floats up(above), down(places.depth[sender.layer] - above);
    for (int block = 0; block < ways.count[layer]; ++block) {
      const LaneWayBlock& b = ways.of[layer][block];
      std::int64_t* sums = sender.targets + ways.first_target[layer][block];
      for (int j = 0; j < LaneWayBlock::kCount; j += kLanes) {
        const Vec3<Floats> wo{Floats::load(b.x + j), Floats::load(b.y + j), Floats::load(b.z + j)};
        Floats value = Floats::load(b.sent + j);
        if constexpr (!kSubstrate) {
          const Floats way = select(wo.z > Floats(0), up, down);
          value = value * sender.medium.density(sender.event, wo) *
                  exp(-(way * Floats::load(b.rate + j)));
        }
        sender.give(wo, value, sums + j, t.way_targets);
      }
    }
  }
};

}  // namespace

void aim_bounded_lanes(const LaneWalkTask& t) {
  queued_walks_of<3, BoundedMedia<Floats>>(t, NextEventAlongWays{{t}});
}

}  // namespace lamella::LAMELLA_ISA
