// Walks through a density grid, a lane each. Those that fly, those that have collided and those
// that have reached the substrate are kept in piles apart, so that all lanes of a register do the
// same.

#include "volume/grid_walk/grid_lattice.h"
#include "volume/grid_walk/lane_march.h"
#include "volume/grid_walk/turned_flakes.h"
#include "volume/grid_walk/walk_piles.h"
#include "volume/lanes/lane_cells.h"
#include "volume/lanes/lane_step.h"

namespace lamella::LAMELLA_ISA {
namespace {

// Cells or tentative collisions by turn of a walk that flies.
constexpr int kFlightSteps = 2;
// The least optical depth that is left of a flight.
constexpr float kNearly = 1e-30f;

template <int C>
class GridWalksOnLanes {
 public:
  explicit GridWalksOnLanes(const GridWalkTask& t) : t_(t) {}

  GridWalkCount run() {
    for (;;) {
      while (made_ < t_.count && under_way() + kLanes <= kWalksUnderWay) begin();
      if (under_way() == 0) break;
      fly();
      // Few that have collided wait for others, while there are some.
      const bool last = made_ == t_.count && flying_.size < kLanes;
      while (collided_.size >= kLanes || (last && collided_.size > 0)) scatter();
      while (below_.size >= kLanes || (last && below_.size > 0)) reflect();
    }
    find_cells();
    return {collisions_, any(too_low_)};
  }

 private:
  using Walkers = GridWalkers<C>;

  [[nodiscard]] int under_way() const { return flying_.size + collided_.size + below_.size; }

  // The word in the place of a random one: the lattice's, where it has one for these steps.
  LAMELLA_INLINE Words word_of_step(int word, Words step, Words slot, Words random) const {
    if (t_.walk.lattice == nullptr) return random;
    const Words point = reversed_bits(Words(t_.point) + slot);
    const Words found = lattice_word(*t_.walk.lattice, word, step, point, Words(t_.shift));
    return select(is_below(step, Words(kLatticeSteps)), found, random);
  }

  [[nodiscard]] LAMELLA_INLINE Floats last_place(int a) const {
    return Floats(static_cast<float>(t_.grid.voxels[a]) * static_cast<float>(kBelowEnd));
  }

  // The next walks, at a random place of the tile's top or bottom.
  [[gnu::noinline]] void begin() {
    const int n = t_.count - made_ < kLanes ? t_.count - made_ : kLanes;
    Walkers w;
    const Words ramp = Words::iota();
    w.slot = Words(static_cast<std::uint32_t>(made_)) + ramp;
    const Words index = Words(t_.index_low) + w.slot * Words(t_.index_stride);
    w.numbers = WalkNumbers<Words>(philox(
        Words(0u), Words(kLaneWalkStream), index, Words(t_.index_high),
        static_cast<std::uint32_t>(t_.walk.seed), static_cast<std::uint32_t>(t_.walk.seed >> 32)));
    w.order = Words(0u);
    for (Floats& weight : w.weight) weight = Floats(1);
    w.wi = {Floats(t_.walk.wi[0]), Floats(t_.walk.wi[1]), Floats(t_.walk.wi[2])};
    if (t_.light[0] != nullptr)
      w.wi = {Floats::load(t_.light[0] + made_), Floats::load(t_.light[1] + made_),
              Floats::load(t_.light[2] + made_)};
    for (int a = 0; a < 2; ++a) {
      const Words word = word_of_step(kEventWord + a, Words(0u), w.slot, w.numbers.next());
      w.place[a] =
          min(fine_uniform_of(word) * Floats(static_cast<float>(t_.grid.voxels[a])), last_place(a));
    }
    w.place[2] = t_.walk.from_above ? last_place(2) : Floats(0);
    take_off(w, sigma_of(w.wi));
    flying_.add(w, first_lanes<float>(n));
    made_ += n;
  }

  // The numbers of the next flight.
  LAMELLA_INLINE void take_off(Walkers& w, Floats sigma) const {
    w.scale = Floats(t_.density) * sigma;
    w.remaining = exponential_of(word_of_step(kFlightWord, w.order, w.slot, w.numbers.next()));
    w.accept = word_of_step(kAcceptanceWord, w.order, w.slot, w.numbers.next());
  }

  // sigma(w) where it belongs to the direction alone, else 1.
  [[nodiscard]] LAMELLA_INLINE Floats sigma_of(Vec3<Floats> w) const {
    Floats sigma(1);
    if (!t_.scaled) return sigma;
    with_medium([&](const auto& medium)
                    LAMELLA_INLINE_LAMBDA { sigma = reciprocal(medium.inverse_area(w)); });
    return sigma;
  }
  template <class F>
  LAMELLA_INLINE void with_medium(const F& f) const {
    with_lane_medium(t_.walk, 0, [&]<template <class> class M>() LAMELLA_INLINE_LAMBDA {
      if constexpr (M<Floats>::kKind != LaneMediumKind::substrate)
        f(M<Floats>(OneLayer<Floats>{*t_.walk.layers, 0}));
    });
  }

  // The voxels per mm of the way along -w_i, none 0; upwards fast enough for places in float.
  LAMELLA_INLINE void speed_of(Vec3<Floats> wi, Floats (&speed)[3]) const {
    constexpr float kLeast = 1e-12f, kLeastClimb = 1e-7f;
    const Floats from[3] = {wi.x, wi.y, wi.z};
    for (int a = 0; a < 3; ++a) speed[a] = -from[a] * Floats(t_.per_mm[a]);
    const Floats climb = (abs(speed[0]) + abs(speed[1])) *
                         Floats(kLeastClimb * static_cast<float>(t_.grid.voxels[2]));
    for (int a = 0; a < 3; ++a) {
      const Floats least = a == 2 ? max(climb, Floats(kLeast)) : Floats(kLeast);
      speed[a] = copysign(max(abs(speed[a]), least), speed[a]);
    }
  }

  // A turn of all walks that fly. Each takes as many steps, and as many numbers, whatever happens
  // to it and whoever flies beside it.
  [[gnu::noinline]] void fly() {
    const int count = flying_.size;
    flying_.size = 0;
    for (int first = 0; first < count; first += kLanes) {
      Walkers w;
      flying_.load(first, w);
      Floats speed[3];
      speed_of(w.wi, speed);
      LaneMarch march(t_.grid, w.place, speed);
      const FloatMask all = first_lanes<float>(count - first < kLanes ? count - first : kLanes);
      FloatMask flies = all, hit = all ^ all, out = hit;
      for (int k = 0; k < kFlightSteps; ++k) step(w, march, flies, hit, out);
      for (int a = 0; a < 3; ++a) w.place[a] = march.place(a);
      flying_.add(w, flies);
      if (any(hit)) collided_.add(w, hit);
      if (any(out)) leave(w, march.goes_up(), out);
    }
  }

  // To the next tentative collision or out of the cell.
  LAMELLA_INLINE void step(Walkers& w, LaneMarch& march, FloatMask& flies, FloatMask& hit,
                           FloatMask& out) {
    const auto cell = march.cell();
    const Floats majorant =
        cell.density * (t_.grid.turned ? Floats(t_.bound) : w.scale * Floats(t_.bound));
    // Empty cells have no collisions: infinity.
    const Floats free = w.remaining / majorant;
    const FloatMask meets = flies & (free < cell.exit), passes = without(flies, meets);
    march.go_on(cell, select(flies, min(free, cell.exit), Floats(0)));
    const Floats extinction = w.scale * march.thickness(march.content(), w.wi);
    too_low_ = too_low_ | (meets & (extinction > majorant * Floats(kRounding)));
    const FloatMask real = meets & (fine_uniform_of(w.accept) * majorant <= extinction);
    const FloatMask null = without(meets, real);
    const Words next = w.numbers.next(), accept = w.numbers.next();
    const Floats left = max(w.remaining - majorant * cell.exit, Floats(kNearly));
    w.remaining = select(null, exponential_of(next), select(passes, left, w.remaining));
    w.accept = select(to_word_mask(null), accept, w.accept);
    const FloatMask gone = march.leave(passes, cell);
    out = out | gone;
    hit = hit | real;
    flies = without(flies, gone | real);
  }

  LAMELLA_INLINE void leave(const Walkers& w, FloatMask up, FloatMask out) {
    FloatMask ends = out;
    if (t_.walk.substrate) {
      const FloatMask down = without(out, up);
      if (any(down)) below_.add(w, down);
      ends = out & up;
    }
    end(w, ends, select(to_word_mask(up), end_word(WalkEnd::up), end_word(WalkEnd::down)));
  }
  LAMELLA_INLINE static Words end_word(WalkEnd end) {
    return Words(static_cast<std::uint32_t>(end));
  }

  // Walks end: each to its row.
  LAMELLA_INLINE void end(const Walkers& w, FloatMask which, Words how) {
    const int n = count(which);
    if (n == 0) return;
    alignas(64) std::uint32_t rows[6 + C][kLanes];
    store_compressed(w.slot, which, rows[0]);
    store_compressed(how, which, rows[1]);
    store_compressed(w.order, which, rows[2]);
    store_compressed(bits_of(w.wi.x), which, rows[3]);
    store_compressed(bits_of(w.wi.y), which, rows[4]);
    store_compressed(bits_of(w.wi.z), which, rows[5]);
    for (int c = 0; c < C; ++c) store_compressed(bits_of(w.weight[c]), which, rows[6 + c]);
    const GridWalkEnds& to = t_.ends;
    const auto number = [](std::uint32_t word)
                            LAMELLA_INLINE_LAMBDA { return __builtin_bit_cast(float, word); };
    for (int j = 0; j < n; ++j) {
      const std::uint32_t slot = rows[0][j];
      to.end[slot] = rows[1][j];
      to.order[slot] = rows[2][j];
      for (int a = 0; a < 3; ++a) to.wi[a][slot] = number(rows[3 + a][j]);
      for (int c = 0; c < C; ++c) to.weight[c][slot] = number(rows[6 + c][j]);
    }
  }

  // The last registerful of a pile.
  LAMELLA_INLINE FloatMask take(WalkPile<C>& pile, Walkers& w) const {
    const int n = pile.size < kLanes ? pile.size : kLanes;
    pile.size -= n;
    pile.load(pile.size, w);
    return first_lanes<float>(n);
  }

  // Walks meet an event: those that have had as many as are followed end. Which of them go on.
  LAMELLA_INLINE FloatMask meet(Walkers& w, FloatMask here) {
    const FloatMask over =
        without(here, to_float_mask(is_below(w.order, Words(t_.walk.max_order))));
    end(w, over, end_word(WalkEnd::unresolved));
    w.order = w.order + Words(1u);
    return without(here, over);
  }

  // The words of an event, the first of which is a flight's in lane_media.h and no one's here.
  template <int kWords>
  LAMELLA_INLINE void draw(Walkers& w, Words (&words)[kEventWords]) const {
    words[0] = Words(0u);
    for (int k = 1; k < kWords; ++k) {
      words[k] = w.numbers.next();
      if (k < kAcceptanceWord) words[k] = word_of_step(k, w.order, w.slot, words[k]);
    }
  }

  // After an event that sends walks along -next and keeps these shares; which of them it leaves.
  LAMELLA_INLINE FloatMask survive(Walkers& w, FloatMask here, const Floats (&kept)[3],
                                   Vec3<Floats> next) {
    const Words roulette = word_of_step(kGridRouletteWord, w.order, w.slot, w.numbers.next());
    LaneState<Floats, 3> state;
    state.order = w.order;
    for (int c = 0; c < 3; ++c) state.weight[c] = w.weight[c < C ? c : 0];
    const FloatMask absorbed = weigh(state, kept, t_.walk.grey, here, uniform_of(roulette));
    for (int c = 0; c < C; ++c) w.weight[c] = state.weight[c];
    w.wi = next;
    // What is not finite ends as well: its row tells.
    const FloatMask gone = absorbed | without(here, dot(next, next) < Floats(2));
    end(w, gone, end_word(WalkEnd::absorbed));
    return without(here, gone);
  }

  [[gnu::noinline]] void scatter() {
    Walkers w;
    const FloatMask here = meet(w, take(collided_, w));
    collisions_ += static_cast<std::uint64_t>(count(here));
    if (t_.grid.turned)
      return t_.mirror ? scatter_turned<true>(w, here) : scatter_turned<false>(w, here);
    with_medium([&](const auto& medium) LAMELLA_INLINE_LAMBDA {
      using M = std::remove_cvref_t<decltype(medium)>;
      Words words[kEventWords];
      draw<M::kWords>(w, words);
      const auto scattered = medium.sample(medium.collide(w.wi, words), words);
      const FloatMask lives = survive<M::kMirror>(w, here, scattered);
      go_on(w, lives, t_.scaled ? reciprocal(medium.inverse_area(w.wi)) : Floats(1));
    });
  }

  // Flakes of the voxel that each walk is in.
  template <bool kMirror>
  LAMELLA_INLINE void scatter_turned(Walkers& w, FloatMask here) {
    Words words[kEventWords];
    draw<kMirror ? 3 : 5>(w, words);
    const LaneVoxel voxel = content_at(t_.grid, w.place);
    const auto flakes = turned_flakes(voxel.first, voxel.v, Floats(t_.grid.sign));
    const Vec3<Floats> m = along_visible_normal(flakes, w.wi, sphere_point_of<Floats>(words + 1));
    const Vec3<Floats> normal = reciprocal_sqrt(max(dot(m, m), Floats(1e-30f))) * m;
    LaneScatter<Floats> scattered;
    if constexpr (kMirror)
      scattered = mirrored(LaneEvent<Floats>{w.wi, normal, Floats(1)});
    else
      scattered = {next_by_lambert(normal, words + 3), Floats(1)};
    go_on(w, survive<kMirror>(w, here, scattered), Floats(1));
  }

  template <bool kMirror>
  LAMELLA_INLINE FloatMask survive(Walkers& w, FloatMask here,
                                   const LaneScatter<Floats>& scattered) {
    const auto& layer = t_.walk.layers->value;
    Floats kept[3];
    for (int c = 0; c < 3; ++c) {
      kept[c] = Floats(layer[kAlbedo + c][0]);
      if (!kMirror || !t_.walk.fresnel) continue;
      const Floats f0(layer[kF0 + c][0]);
      kept[c] = kept[c] * multiply_add(schlick_weight(scattered.cosine), Floats(1) - f0, f0);
    }
    return survive(w, here, kept, scattered.next);
  }

  // The substrate's events.
  [[gnu::noinline]] void reflect() {
    using Substrate = SubstrateOnLanes<Floats>;
    Walkers w;
    const FloatMask here = meet(w, take(below_, w));
    Words words[kEventWords];
    draw<Substrate::kWords>(w, words);
    const Substrate substrate(0);
    const auto scattered = substrate.sample(substrate.collide(w.wi, words), words);
    Floats kept[3];
    for (int c = 0; c < 3; ++c) kept[c] = Floats(t_.walk.substrate_albedo[c]);
    w.place[2] = Floats(0);
    const FloatMask lives = survive(w, here, kept, scattered.next);
    go_on(w, lives, sigma_of(w.wi));
  }

  // Those that an event leaves fly on.
  LAMELLA_INLINE void go_on(Walkers& w, FloatMask lives, Floats sigma) {
    take_off(w, sigma);
    flying_.add(w, lives);
  }

  [[gnu::noinline]] void find_cells() const {
    if (!t_.cells.on) return;
    for (int k = 0; k < t_.count; k += kLanes) {
      const Vec3<Floats> wi{Floats::load(t_.ends.wi[0] + k), Floats::load(t_.ends.wi[1] + k),
                            Floats::load(t_.ends.wi[2] + k)};
      cell_of(t_.cells, wi).store(t_.ends.cell + k);
    }
  }

  const GridWalkTask& t_;
  int made_ = 0;
  std::uint64_t collisions_ = 0;
  FloatMask too_low_ = first_lanes<float>(0);
  WalkPile<C> flying_, collided_, below_;
};

}  // namespace

GridWalkCount walk_grid_lanes(const GridWalkTask& t) {
  return t.walk.grey ? GridWalksOnLanes<1>(t).run() : GridWalksOnLanes<3>(t).run();
}

}  // namespace lamella::LAMELLA_ISA
