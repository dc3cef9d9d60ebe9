#pragma once

// First flights that do not leave: the walk collides within the stack and goes on as the share of
// the light that does; the rest is booked as if so much of the walk had left. No order of the first
// ones depends on whether a walk is still there, so that lattices see a smooth function. Only for
// sources of lamella_lanes().

#include "phase/random/lane_truncated.h"
#include "volume/lanes/lane_pool.h"
#include "volume/lanes/lane_step.h"

namespace lamella::LAMELLA_ISA {

/// Sums of floats per lane in fixed point, without 64-bit arithmetic: multiples of 2^-6 and what
/// remains in multiples of 1 / kPointUnits. Terms up to kPointLimit, kMost of them.
struct FixedPointLanes {
  // Of up to 2^25 in `fine`.
  static constexpr int kMost = 63;
  alignas(64) std::uint32_t coarse[kLanes] = {}, fine[kLanes] = {};  // two's complement

  struct Term {
    Words coarse, fine;
    LAMELLA_INLINE explicit Term(Floats x) {
      coarse = to_nearest_words(x * Floats(0x1p6f));
      const Floats rest = multiply_add(to_floats(coarse), Floats(-0x1p-6f), x);
      fine = to_nearest_words(rest * Floats(0x1p32f));
    }
  };
  LAMELLA_INLINE void add(const Term& term, FloatMask here) {
    const auto add_to = [&](std::uint32_t* sums, Words x) LAMELLA_INLINE_LAMBDA {
      const Words old = Words::load(sums);
      select(to_word_mask(here), old + x, old).store(sums);
    };
    add_to(coarse, term.coarse);
    add_to(fine, term.fine);
  }
  /// The sum in units of 1 / kPointUnits; begins anew.
  [[nodiscard]] std::int64_t take() {
    std::int64_t sum = 0;
    for (int k = 0; k < kLanes; ++k)
      sum += (std::int64_t{static_cast<std::int32_t>(coarse[k])} << 26) +
             static_cast<std::int32_t>(fine[k]);
    *this = {};
    return sum;
  }
};

/// The shares of walks that left on forced flights, and what roulette took of the others, on their
/// way into the sums of a batch.
class ForcedLeavers {
 public:
  /// Adds shares of walks after 1 to kForcedFlights - 1 events; `down` as the flight goes.
  LAMELLA_INLINE void add(Floats shares, Words events, FloatMask down, FloatMask who) {
    const FixedPointLanes::Term term(shares);
    for (std::uint32_t k = 1; k < kForcedFlights; ++k) {
      const FloatMask here = who & to_float_mask(equal(events, Words(k)));
      if (!any(here)) continue;
      shares_[0][k - 1].add(term, without(here, down));
      shares_[1][k - 1].add(term, here & down);
    }
    ++terms_;
  }
  /// Adds what roulette took, below 0 where it gave. At most once per `add`.
  LAMELLA_INLINE void add_taken(Floats shares, Words events, FloatMask who) {
    const FixedPointLanes::Term term(shares);
    for (std::uint32_t k = 1; k < kForcedFlights; ++k)
      shares_[2][k - 1].add(term, who & to_float_mask(equal(events, Words(k))));
  }
  [[nodiscard]] LAMELLA_INLINE bool is_full() const { return terms_ == FixedPointLanes::kMost; }
  /// to: LaneSums::forced.
  [[gnu::noinline]] void empty(std::int64_t* to) {
    for (auto& side : shares_)
      for (FixedPointLanes& sum : side) *to++ += sum.take();
    terms_ = 0;
  }

 private:
  int terms_ = 0;
  FixedPointLanes shares_[3][kForcedFlights - 1] = {};
};

/// Whether a loop has flights that are forced, where the setting asks for them.
template <class Set, class Score>
[[nodiscard]] constexpr bool forces_flights() {
  if constexpr (requires { Score::kForces; })
    return Score::kForces && !Set::kBounded && !Set::kCountsSteps;
  else
    return false;
}

/// What forcing makes of flights.
struct ForcedShare {
  FloatMask forced, dies;  ///< which flights are forced; of which walks roulette leaves nothing
  Floats remaining;        ///< mean free paths to the collision, of all flights
};

/// Forces the flights, of the lanes `flies`, that follow the first events. w.weight[0] is the share
/// of the walk that goes on; where little is left of it, roulette ends the walk as an event does,
/// and the ledger has what it takes and gives.
/// depth(down): the optical depth from where walks are to where they would leave.
template <class Score, class Depth>
LAMELLA_INLINE ForcedShare force(const WalkSetting<float>& t, LaneState<Floats, 0>& w,
                                 const LaneDraws<Floats>& draws, FloatMask flies,
                                 LaneEnds<Floats>& now, const Score& score, const Depth& depth) {
  constexpr float kLittle = 0.15f;
  const FloatMask none = without(flies, flies);
  ForcedShare share{flies & to_float_mask(is_below(w.order, Words(t.forced_flights))), none,
                    draws.remaining};
  // One number per step, whatever becomes of the walk.
  const Floats luck = uniform_of(w.numbers.next());
  if (!any(share.forced)) return share;
  const FloatMask down = w.wi.z > Floats(0);
  const Floats chance = collision_chance(min(depth(down), Floats(80)));
  const Floats stays = w.weight[0] * chance;
  score.leave(w.weight[0] - stays, w.order, down, share.forced);
  const FloatMask little = share.forced & (stays < Floats(kLittle));
  share.dies = little & (luck * Floats(kLittle) >= stays);
  if (any(little))
    score.take(stays - select(share.dies, Floats(0), Floats(kLittle)), w.order, little);
  w.weight[0] = select(share.forced, select(little, Floats(kLittle), stays), w.weight[0]);
  share.remaining =
      select(share.forced, truncated_exponential_of(chance, draws.words[0]), share.remaining);
  now.lives = without(now.lives, share.dies);
  now.gone = now.gone | share.dies;
  return share;
}

/// Optical depth per length of a way whose 1 / sigma is `inverse`. Never infinite.
LAMELLA_INLINE Floats rate_of(Floats inverse, Floats wz) {
  return min(reciprocal(max(inverse * abs(wz), Floats(1e-30f))), Floats(1e30f));
}

/// The flight within one layer that follows an event. kFull: see scatter.
template <bool kFull, class Set, class Score>
LAMELLA_INLINE void fly_forced(const WalkSetting<float>& t, const Set& set, LaneState<Floats, 0>& w,
                               const LaneDraws<Floats>& draws, FloatMask active,
                               LaneEnds<Floats>& now, const Score& score) {
  const FloatMask flies = kFull ? now.lives : active & now.lives;
  const Floats inverse = set.medium.inverse_area(w.wi);
  const ForcedShare share =
      force(t, w, draws, flies, now, score, [&](FloatMask down) LAMELLA_INLINE_LAMBDA {
        return select(down, set.depth - w.y, w.y) * rate_of(inverse, w.wi.z);
      });
  const Floats to = multiply_add(share.remaining * inverse, w.wi.z, w.y);
  const FloatMask inside = is_within(to, set.depth);
  // What rounding sends out collides at the end of the way.
  w.y = select(share.forced, min(nonnegative(to), set.depth), to);
  const FloatMask goes_on = without(flies & (share.forced | inside), share.dies);
  now.ends = kFull ? !goes_on : without(active, goes_on);
}

/// The optical depth from where walks are to where they would leave a stack of several layers.
LAMELLA_INLINE Floats depth_to_exit(const AnyMedia<Floats>& set, const LaneState<Floats, 0>& w,
                                    FloatMask down) {
  Floats sum(0);
  for (int k = 0; k < set.t.layer_count; ++k) {
    const Words layer(static_cast<std::uint32_t>(k));
    const Floats depth(set.t.layers->value[kDepth][k]);
    const WordMask here = equal(w.layer, layer);
    const FloatMask beyond = (down & to_float_mask(is_below(w.layer, layer))) |
                             without(to_float_mask(is_below(layer, w.layer)), down);
    const Floats way = select(to_float_mask(here), select(down, depth - w.y, w.y),
                              select(beyond, depth, Floats(0)));
    sum = multiply_add(way, rate_of(set.inverse_area(layer, w.wi), w.wi.z), sum);
  }
  return sum;
}

/// Gives flights that rounding sent out of a stack their collision at the end of the way.
LAMELLA_INLINE void keep_inside(const AnyMedia<Floats>& set, LaneState<Floats, 0>& w,
                                const ForcedShare& share, FloatMask lives,
                                AnyMedia<Floats>::Flight& flight) {
  const FloatMask out = without(share.forced & lives, flight.collides);
  if (!any(out)) return;
  const int last = set.t.layer_count - 1;
  w.layer =
      select(to_word_mask(out),
             select(to_word_mask(flight.down), Words(static_cast<std::uint32_t>(last)), Words(0u)),
             w.layer);
  w.y = select(out, select(flight.down, Floats(set.t.layers->value[kDepth][last]), Floats(0)), w.y);
  flight.collides = flight.collides | out;
}

}  // namespace lamella::LAMELLA_ISA
