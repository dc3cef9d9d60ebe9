#include "volume/lane_walk.h"

#include "volume/lane_media.h"
#include "volume/lane_points.h"

namespace lamella::LAMELLA_ISA {

#define LAMELLA_INLINE_LAMBDA __attribute__((always_inline))

namespace {

constexpr int kLanes = Floats::kCount;
constexpr std::uint32_t kOrders = 4;  // kTallyOrders

// Walks that are about to have their first collision, made many at once, for lanes that fall free.
struct Pool {
  static constexpr int kSize = 256;
  int from = 0, to = 0;
  std::uint32_t made = 0;  // walks begun so far
  std::uint64_t uncollided = 0;
  alignas(64) std::uint32_t index[kSize + 2 * kLanes];
  alignas(64) std::uint32_t death[kSize + 2 * kLanes];
  alignas(64) float y[kSize + 2 * kLanes];

  // Fills up to kSize, until the walks of the task are used up.
  [[gnu::noinline]] void fill(const LaneWalkTask& t) {
    const int left = to - from;
    for (int k = 0; k < left; k += kLanes) {
      Words::load(index + from + k).store(index + k);
      Words::load(death + from + k).store(death + k);
      Floats::load(y + from + k).store(y + k);
    }
    from = 0;
    to = left;
    const bool down = t.from_above;
    while (to < kSize && made < t.walks) {
      const std::uint32_t rest = t.walks - made;
      const Words number = Words(made) + Words::iota();
      const Words walk =
          Words(t.index_low) + Words(hn::Vec<Words::Tag>((number * Words(t.index_stride)).v));
      const WordBlock block =
          philox(Words(0u), Words(kLaneStartStream), walk, Words(t.index_high),
                 static_cast<std::uint32_t>(t.seed), static_cast<std::uint32_t>(t.seed >> 32));
      const Floats uniform = fine_uniform_of(block.w[0]);
      Floats way = -log(uniform) * Floats(t.first_flight);
      if (t.forced_chance > 0) {
        // -log(1 - x), x the uniform number times the chance
        const Floats x = uniform * Floats(t.forced_chance);
        Floats p = multiply_add(x, Floats(0.2f), Floats(0.25f));
        p = multiply_add(x, p, Floats(1.0f / 3));
        p = multiply_add(x, p, Floats(0.5f));
        way = min(multiply_add(x * x, p, x) * Floats(t.first_flight), Floats(t.depth));
      }
      const Floats start = down ? way : Floats(t.depth) - way;
      FloatMask hits = down ? start < Floats(t.depth) : start > Floats(0);
      if (t.forced_chance > 0) hits = first_lanes<float>(kLanes);
      // The event at which the roulette of the fourth and later ones ends the walk.
      const Floats survived =
          min(-log(fine_uniform_of(block.w[1])) * Floats(t.orders_per_absorption), Floats(1e9f));
      const Words last = t.black ? Words(1u) : to_words(survived) + Words(kOrders);
      const int n = rest < static_cast<std::uint32_t>(kLanes) ? static_cast<int>(rest) : kLanes;
      const FloatMask exist = first_lanes<float>(n);
      hits = hits & exist;
      const int found = count(hits);
      uncollided += static_cast<std::uint64_t>(n - found);
      store_compressed(walk, hits, index + to);
      store_compressed(last, hits, death + to);
      store_compressed(start, hits, y + to);
      to += found;
      made += static_cast<std::uint32_t>(n);
    }
  }
};

// Walks that ended, until there are enough of them to count them at a stretch.
struct Ended {
  static constexpr int kSize = 512;
  int size = 0;
  alignas(64) std::uint32_t code[kSize + 2 * kLanes];  // WalkEnd + 4 order
  alignas(64) float x[kSize + 2 * kLanes];             // w_i of the last flight
  alignas(64) float y[kSize + 2 * kLanes];
  alignas(64) float z[kSize + 2 * kLanes];

  [[gnu::noinline]] void count_all(const LaneWalkTask& t) {
    const Words end_stride(t.order_cap + 1), cap(t.order_cap);
    const std::uint32_t targets =
        static_cast<std::uint32_t>(t.cells.rows * t.cells.columns * (t.cells.both_sides ? 2 : 1));
    alignas(64) std::uint32_t place[kLanes];
    for (int k = 0; k < size; k += kLanes) {
      const int n = size - k < kLanes ? size - k : kLanes;
      const Words c = Words::load(code + k), end = c & Words(3u), order = shift_right<2>(c);
      (end * end_stride + min(order, cap)).store(place);
      for (int j = 0; j < n; ++j) ++t.ends[place[j]];
      if (!t.cells.on) continue;
      const Floats wz = Floats::load(z + k);
      // w_o = -w_i: half a turn further than w_i.
      Floats turns =
          turns_of(Floats::load(y + k), Floats::load(x + k)) + Floats(0.5f - t.cells.azimuth_turns);
      turns = turns - floor(turns);
      if (t.cells.folded) turns = min(turns, Floats(1) - turns);
      const Floats row = min(nonnegative((Floats(1) - wz * wz) * Floats(t.cells.rows)),
                             Floats(t.cells.rows - 0.5f));
      const Floats column = min(turns * Floats(t.cells.phi_cells), Floats(t.cells.columns - 0.5f));
      const WordMask down = equal(end, Words(static_cast<std::uint32_t>(WalkEnd::down)));
      const WordMask left = (order > Words(0u)) &
                            (end < Words(static_cast<std::uint32_t>(
                                       t.cells.both_sides ? WalkEnd::absorbed : WalkEnd::down)));
      const Words below = select(
          down, Words(static_cast<std::uint32_t>(t.cells.rows * t.cells.columns)), Words(0u));
      const Words slot = max(min(order, Words(kOrders)), Words(1u)) - Words(1u);
      const Words target = to_words(row) * Words(static_cast<std::uint32_t>(t.cells.columns)) +
                           to_words(column) + below + slot * Words(targets);
      select(left, target, Words(kOrders * targets)).store(place);
      for (int j = 0; j < n; ++j) ++t.cells.counts[place[j]];
    }
    size = 0;
  }
};

// The walks of a task, each lane taking the next walk as soon as its own has ended. The numbers of
// an event are those of (seed, walk, step), so that it does not matter when and where it happens.
template <class M, class Points>
void walks_of(const LaneWalkTask& t, Points points) {
  const M medium(t.medium);
  const auto key0 = static_cast<std::uint32_t>(t.seed);
  const auto key1 = static_cast<std::uint32_t>(t.seed >> 32);
  const Words purpose(kLaneWalkStream), index_high(t.index_high);
  const Direction16 incident = broadcast(t.wi);
  const Floats depth(t.depth);
  const Words max_order(t.max_order);
  Pool pool;
  Ended ended;
  std::uint64_t steps = 0, busy = 0;
  FloatMask bad = first_lanes<float>(0);
  Words bad_walk(0u);
  // Two sets of lanes that know nothing of each other: while one waits for its numbers, the other's
  // are computed.
  constexpr int kSets = 2;
  struct Walks {
    Direction16 wi;
    Floats y;
    Words order, death, index, step;
    FloatMask active, free;
  };
  Walks sets[kSets];
  for (Walks& w : sets) {
    w = {incident,
         Floats(0),
         Words(0u),
         Words(1u),
         Words(0u),
         Words(0u),
         first_lanes<float>(0),
         first_lanes<float>(kLanes)};
  }
  pool.fill(t);

  const auto refill = [&](Walks& w) LAMELLA_INLINE_LAMBDA {
    const int available = pool.to - pool.from;
    const Words rank = rank_of(w.free);
    const FloatMask take =
        w.free & to_float_mask(rank < Words(static_cast<std::uint32_t>(available)));
    const WordMask words = to_word_mask(take);
    w.index = select(words, permute(Words::load(pool.index + pool.from), rank), w.index);
    w.death = select(words, permute(Words::load(pool.death + pool.from), rank), w.death);
    w.y = select(take, permute(Floats::load(pool.y + pool.from), rank), w.y);
    w.order = select(words, Words(0u), w.order);
    if constexpr (M::kNull) w.step = select(words, Words(0u), w.step);
    w.wi = select(take, incident, w.wi);
    w.active = (w.active & !w.free) | take;
    pool.from += count(take);
    if (pool.to - pool.from < kLanes) pool.fill(t);
  };

  // All lanes are at a collision, or a null one: the event and the flight to the next one.
  const auto step = [&](Walks& w) LAMELLA_INLINE_LAMBDA {
    WordBlock words[M::kWords];
    const Words number = M::kNull ? w.step : w.order;
    words[0] = philox(number, purpose, w.index, index_high, key0, key1);
    if constexpr (M::kWords > 1)
      words[1] = philox(number | Words(0x80000000u), purpose, w.index, index_high, key0, key1);
    if constexpr (M::kNull) w.step = w.step + Words(1u);
    const auto event = medium.collide(w.wi, words);
    FloatMask scatters = w.active;
    if constexpr (M::kNull) scatters = w.active & event.accepted;
    const FloatMask over = scatters & to_float_mask(equal(w.order, max_order));
    const FloatMask counts = scatters & !over;
    w.order = select(to_word_mask(counts), w.order + Words(1u), w.order);
    points(medium, event, w.y, w.order, counts);
    const FloatMask dead = counts & to_float_mask(w.order >= w.death);
    const Direction16 wo = medium.sample(event, words);
    if constexpr (M::kNull)
      w.wi = select(counts, -wo, w.wi);
    else
      w.wi = -wo;

    const Floats way = -log(fine_uniform_of(words[0].w[0])) * medium.inverse_area(w.wi);
    w.y = multiply_add(way, w.wi.z, w.y);
    const FloatMask down = w.wi.z > Floats(0);
    const FloatMask inside = (down & (w.y < depth)) | (!down & (w.y > Floats(0)));
    const FloatMask ends = (!inside | dead | over) & w.active;
    const FloatMask wrong = ends & !(abs(w.y) < Floats(1e35f));
    bad = bad | wrong;
    bad_walk = select(to_word_mask(wrong), w.index, bad_walk);
    Words end = select(to_word_mask(down), Words(1u), Words(0u));
    end = select(to_word_mask(dead), Words(2u), end);
    end = select(to_word_mask(over), Words(3u), end);
    store_compressed(end + shift_left<2>(w.order), ends, ended.code + ended.size);
    if (t.cells.on) {
      store_compressed(w.wi.x, ends, ended.x + ended.size);
      store_compressed(w.wi.y, ends, ended.y + ended.size);
      store_compressed(w.wi.z, ends, ended.z + ended.size);
    }
    ended.size += count(ends);
    if (ended.size >= Ended::kSize) ended.count_all(t);
    w.free = ends | !w.active;
    busy += static_cast<std::uint64_t>(count(counts));
  };

  for (;;) {
    FloatMask active = first_lanes<float>(0);
    for (Walks& w : sets) {
      refill(w);
      active = active | w.active;
    }
    if (!any(active)) break;
    for (Walks& w : sets) step(w);
    steps += kSets;
  }
  ended.count_all(t);
  const WalkEnd straight = t.from_above ? WalkEnd::down : WalkEnd::up;
  t.ends[static_cast<std::uint32_t>(straight) * (t.order_cap + 1)] += pool.uncollided;
  *t.lane_steps += steps * static_cast<std::uint64_t>(kLanes);
  *t.busy_lane_steps += busy;
  if (any(bad)) {
    alignas(64) std::uint32_t walk[kLanes];
    bad_walk.store(walk);
    *t.bad_walk = (std::uint64_t{t.index_high} << 32) + walk[__builtin_ctz(mask_bits(bad))] + 1;
  }
}

template <class M>
void with_points(const LaneWalkTask& t) {
  if (t.points.count == 0)
    walks_of<M>(t, NoPoints{});
  else if (t.points.count <= FewPoints::kMost)
    walks_of<M>(t, FewPoints{t.points, t.depth});
  else
    walks_of<M>(t, ManyPoints{t.points, t.depth});
}

}  // namespace

void walk_lanes(const LaneWalkTask& task) {
  switch (task.medium.kind) {
    case LaneMediumKind::lambert_sphere:
      return with_points<LaneLambertSphere>(task);
    case LaneMediumKind::henyey_greenstein:
      return with_points<LaneHenyeyGreenstein>(task);
    case LaneMediumKind::sggx_mirror:
      return with_points<LaneSggxMirror>(task);
    case LaneMediumKind::sggx_lambert:
      return with_points<LaneSggxLambert>(task);
    case LaneMediumKind::vmf_lambert:
      return with_points<LaneVmfLambert>(task);
    case LaneMediumKind::vmf_mirror:
      return walks_of<LaneVmfMirror>(task, NoPoints{});
  }
}

}  // namespace lamella::LAMELLA_ISA
