#pragma once

// Next-event estimation on lanes: every event sends its light to every direction asked for. Only
// for sources of lamella_lanes().

#include "volume/lanes/lane_loop.h"

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

/// A lane's event, for all lanes to see.
struct StoredEvents {
  alignas(64) float numbers[4][kLanes];
  template <class M>
  LAMELLA_INLINE StoredEvents(const M&, const LaneEvent<Floats>& e) {
    const Vec3<Floats> w = M::kDiffuse ? e.normal : e.wi;
    w.x.store(numbers[0]), w.y.store(numbers[1]), w.z.store(numbers[2]);
    e.inverse_sigma.store(numbers[3]);
  }
  [[nodiscard]] LAMELLA_INLINE LaneEvent<Floats> of(int lane) const {
    const Vec3<Floats> w{Floats(numbers[0][lane]), Floats(numbers[1][lane]),
                         Floats(numbers[2][lane])};
    return {w, w, Floats(numbers[3][lane])};
  }
};

/// Gives events to the sums of points or cells. C: weights that walks carry.
template <int C>
struct NextEventOnLanes {
  static constexpr bool kUsesIndex = true, kForces = C == 0;
  // The largest number of points that is taken one point after the other, all lanes at once: beyond
  // it the other order is faster. In one layer of one medium, in any stack, and with weights or
  // colour.
  static constexpr int kFew = kLanes < 8 ? 12 : 32, kFewInStacks = 12, kFewWeighed = 6;

  const LaneWalkTask& t;
  // What few points got from walks without weights and colour, not yet in the sums.
  mutable int few_terms = 0;
  mutable FixedPointLanes few_sums[kFew][kRouletteOrder] = {};
  mutable ForcedLeavers leavers{};

  /// Brings everything to the sums.
  LAMELLA_INLINE void finish() const {
    if (few_terms > 0) empty_few();
    if (t.walk.forced_flights > 0) leavers.empty(t.batches[0].sums->forced);
  }

  /// Shares of walks that leave on forced flights.
  LAMELLA_INLINE void leave(Floats shares, Words events, FloatMask down, FloatMask who) const {
    leavers.add(shares, events, down, who);
    if (leavers.is_full()) leavers.empty(t.batches[0].sums->forced);
  }
  /// What roulette takes of walks after that.
  LAMELLA_INLINE void take(Floats shares, Words events, FloatMask who) const {
    leavers.add_taken(shares, events, who);
  }

  template <class All, class M>
  LAMELLA_INLINE void operator()(All all, const M& medium, const LaneEvent<Floats>& event,
                                 const LaneState<Floats, C>& w, FloatMask scatters) const {
    if (t.estimate != LaneEstimate::points && t.estimate != LaneEstimate::cells_next_event) return;
    const FloatMask counts = scatters & to_float_mask(is_below(w.order, Words(t.walk.max_order)));
    const bool plain = C == 0 && t.channels == 1;
    const bool are_few = t.estimate == LaneEstimate::points && t.batch_count == 1 &&
                         t.points.count <= (!plain       ? kFewWeighed
                                            : All::kSame ? kFew
                                                         : kFewInStacks);
    if (plain && are_few)
      few(all, medium, event, w, counts);
    else if (!any(counts))
      return;
    else if (are_few)
      few_weighed(all, medium, event, w, counts);
    else
      many(all, medium, event, w, counts);
  }

 protected:
  [[gnu::noinline]] void empty_few() const {
    for (int j = 0; j < t.points.count && j < kFew; ++j)
      for (int slot = 0; slot < static_cast<int>(kRouletteOrder); ++slot)
        t.batches[0].sums->targets[slot * t.points.padded + j] += few_sums[j][slot].take();
    few_terms = 0;
  }

  /// What an event of each lane sends out in a channel, Schlick's factor apart.
  template <class M>
  LAMELLA_INLINE Floats share(const M&, const LaneState<Floats, C>& w, int channel) const {
    if constexpr (C > 0) {
      const Floats albedo = M::kKind == LaneMediumKind::substrate
                                ? Floats(t.walk.substrate_albedo[channel])
                                : lookup(t.walk.layers->value[kAlbedo + channel], w.layer);
      return w.weight[channel] * albedo * walks(w);
    } else {
      if (t.channels == 1) return walks(w);
      const Words order = min(w.order + Words(1u), Words(t.order_cap));
      return gather(t.event_weight + static_cast<std::uint32_t>(channel) * (t.order_cap + 1),
                    order) *
             walks(w);
    }
  }
  /// How many walks each stands for, in terms' scale.
  LAMELLA_INLINE Floats walks(const LaneState<Floats, C>& w) const {
    if (C == 0 && t.walk.forced_flights > 0) return w.weight[0] * Floats(t.term_scale);
    if (t.walk.thinned_from == 0) return Floats(t.term_scale);
    return power_of_two(spared_of(t.walk.thinned_from, w.order)) * Floats(t.term_scale);
  }
  [[nodiscard]] LAMELLA_INLINE bool differ_in_number() const {
    return t.walk.thinned_from > 0 || t.walk.forced_flights > 0;
  }
  template <class M>
  [[nodiscard]] LAMELLA_INLINE bool has_fresnel(const M&) const {
    return C > 0 && M::kMirror && t.walk.fresnel;
  }

  struct OfSlots {
    FloatMask of[kRouletteOrder];
    LAMELLA_INLINE OfSlots(Words order, FloatMask counts) {
      for (std::uint32_t k = 0; k + 1 < kRouletteOrder; ++k)
        of[k] = counts & to_float_mask(equal(order, Words(k)));
      of[kRouletteOrder - 1] = counts & to_float_mask(is_below(Words(kRouletteOrder - 2), order));
    }
  };

  /// What an event of each lane sends to point j, albedo and Schlick's factor apart.
  template <class All, class M>
  LAMELLA_INLINE Floats sent(All all, const M& medium, const LaneEvent<Floats>& event,
                             const LaneState<Floats, C>& w, int j) const {
    constexpr int kStride = kMostLaneLayers + 1;
    const LanePoints& p = t.points;
    const Vec3<Floats> wo{Floats(p.x[j]), Floats(p.y[j]), Floats(p.z[j])};
    const float* rates = p.rate_by_point + j * kStride;
    const float* beyond = p.beyond_by_point + j * kStride;
    Floats tau;
    if constexpr (M::kKind == LaneMediumKind::substrate) {
      tau = Floats(beyond[t.walk.layer_count]);
    } else {
      const auto& depths = t.walk.layers->value[kDepth];
      const auto of_layer = [&](const float* numbers) LAMELLA_INLINE_LAMBDA {
        if constexpr (All::kSame)
          return Floats(numbers[all.layer]);
        else
          return lookup(numbers, w.layer);
      };
      const Floats way = j < p.up ? w.y : of_layer(depths) - w.y;
      tau = All::kAlone ? way * Floats(rates[0])
                        : multiply_add(way, of_layer(rates), of_layer(beyond));
    }
    return medium.density(event, wo) * exp(-tau);
  }

  template <class All, class M>
  LAMELLA_INLINE void few(All all, const M& medium, const LaneEvent<Floats>& event,
                          const LaneState<Floats, C>& w, FloatMask counts) const {
    const OfSlots slots(w.order, counts);
    for (int j = 0; j < t.points.count; ++j) {
      Floats value = sent(all, medium, event, w, j);
      if (differ_in_number()) value = value * walks(w);
      const FixedPointLanes::Term term(value);
      for (std::uint32_t k = 0; k < kRouletteOrder; ++k) few_sums[j][k].add(term, slots.of[k]);
    }
    if (++few_terms == FixedPointLanes::kMost) empty_few();
  }

  // By value: what a call takes the address of does not stay in registers.
  template <class All, class M>
  [[gnu::noinline]] void few_weighed(All all, M medium, LaneEvent<Floats> event,
                                     LaneState<Floats, C> w, FloatMask counts) const {
    const OfSlots slots(w.order, counts);
    const LanePoints& p = t.points;
    for (int j = 0; j < p.count; ++j) {
      const Vec3<Floats> wo{Floats(p.x[j]), Floats(p.y[j]), Floats(p.z[j])};
      const Floats value = sent(all, medium, event, w, j);
      for (int c = 0; c < t.channels; ++c) {
        Floats term = value * share(medium, w, c);
        if (has_fresnel(medium)) {
          const Floats f0 = lookup(t.walk.layers->value[kF0 + c], w.layer);
          term = term * multiply_add(schlick_weight(half_cosine(event.wi, wo)), Floats(1) - f0, f0);
        }
        for (std::uint32_t slot = 0; slot < kRouletteOrder; ++slot) {
          if (!any(slots.of[slot])) continue;
          t.batches[0].sums->targets[(static_cast<int>(slot) * t.channels + c) * p.padded + j] +=
              FixedPoint(select(slots.of[slot], term, Floats(0))).sum();
        }
      }
    }
  }

  // One event after the other; each register holds several directions.
  template <class All, class M>
  [[gnu::noinline]] void many(All all, M medium, LaneEvent<Floats> event, LaneState<Floats, C> w,
                              FloatMask counts) const {
    const StoredEvents stored(medium, event);
    alignas(64) float depths[kLanes], places[kLanes], turn_cos[kLanes], turn_sin[kLanes];
    alignas(64) float shares[3][kLanes];
    alignas(64) std::uint32_t orders[kLanes], layers[kLanes], indices[kLanes];
    w.y.store(depths);
    w.order.store(orders);
    w.layer.store(layers);
    w.index.store(indices);
    for (int c = 0; c < t.channels; ++c) share(medium, w, c).store(shares[c]);
    const bool cells = t.estimate == LaneEstimate::cells_next_event;
    if (cells) {
      WordBlock block = LaneNumbers(t)(w.order, kLaneTargetStream, w.index);
      if (t.walk.lattice != nullptr) {
        const Words step = w.order;
        const WordMask early = is_below(step, Words(kLatticeSteps));
        for (int k = 0; k < 2; ++k)
          block.w[k] = select(
              early, lattice_word(*t.walk.lattice, kLatticeTargetWord + k, step, w.point, w.shift),
              block.w[k]);
      }
      multiply_add(to_floats(shift_right<16>(block.w[0])), Floats(0x1p-16f), Floats(0x1p-17f))
          .store(places);
      const auto [sine, cosine] =
          sine_cosine_of_turns(uniform_of(block.w[1]) * Floats(1.0f / t.cells.phi_cells));
      sine.store(turn_sin);
      cosine.store(turn_cos);
    }
    for (std::uint32_t left = mask_bits(counts); left != 0; left &= left - 1) {
      const int lane = __builtin_ctz(left);
      int layer = t.walk.layer_count;
      if constexpr (All::kSame)
        layer = all.layer;
      else if constexpr (M::kKind != LaneMediumKind::substrate)
        layer = static_cast<int>(layers[lane]);
      const std::uint32_t slot =
          orders[lane] + 1 < kRouletteOrder ? orders[lane] : kRouletteOrder - 1;
      if (cells) aim(layer, depths[lane], places[lane], turn_cos[lane], turn_sin[lane]);
      const auto give = [&](const M& at) LAMELLA_INLINE_LAMBDA {
        const Sender<M> sender{
            *this,
            at,
            stored.of(lane),
            layer,
            t.batches[t.batch_of(indices[lane])].sums->targets,
            {Floats(shares[0][lane]), Floats(shares[1][lane]), Floats(shares[2][lane])}};
        if (cells)
          to_cells(sender, slot, depths[lane]);
        else
          to_points(sender, slot, depths[lane]);
      };
      if constexpr (All::kSame || M::kKind == LaneMediumKind::substrate)
        give(medium);
      else
        give(M(OneLayer<Floats>{*t.walk.layers, layer}));
    }
  }

  /// One event's light.
  template <class M>
  struct Sender {
    const NextEventOnLanes& to;
    const M& medium;
    LaneEvent<Floats> event;
    int layer;
    std::int64_t* targets;
    Floats share[3];
    /// Adds density times `attenuation` towards w_o to the sums, a stride apart for channels.
    LAMELLA_INLINE void send(Vec3<Floats> wo, Floats attenuation, std::int64_t* place,
                             int stride) const {
      give(wo, medium.density(event, wo) * attenuation, place, stride);
    }
    LAMELLA_INLINE void give(Vec3<Floats> wo, Floats value, std::int64_t* place, int stride) const {
      const LaneWalkTask& task = to.t;
      if (!task.weighs()) {
        if (to.differ_in_number()) value = value * share[0];
        return FixedPoint(value).add_to(place);
      }
      Floats schlick(0);
      if (to.has_fresnel(medium)) schlick = schlick_weight(half_cosine(event.wi, wo));
      for (int c = 0; c < task.channels; ++c) {
        Floats term = value * share[c];
        if (to.has_fresnel(medium)) {
          const Floats f0(task.walk.layers->value[kF0 + c][layer]);
          term = term * multiply_add(schlick, Floats(1) - f0, f0);
        }
        FixedPoint(term).add_to(place + c * stride);
      }
    }
  };

  template <class M>
  LAMELLA_INLINE void to_points(const Sender<M>& sender, std::uint32_t slot, float y) const {
    const LanePoints& p = t.points;
    const bool substrate = M::kKind == LaneMediumKind::substrate;
    const float depth = substrate ? 0 : t.walk.layers->value[kDepth][sender.layer];
    const Floats above(substrate ? 0 : y), below(depth - y);
    const float* rates = p.rate + sender.layer * p.padded;
    const float* beyond = p.beyond + sender.layer * p.padded;
    std::int64_t* at = sender.targets + static_cast<int>(slot) * t.channels * p.padded;
    for (int j = 0; j < p.padded; j += kLanes) {
      const Vec3<Floats> wo{Floats::load(p.x + j), Floats::load(p.y + j), Floats::load(p.z + j)};
      const Floats way = select(wo.z > Floats(0), above, below);
      const Floats tau = multiply_add(way, Floats::load(rates + j), Floats::load(beyond + j));
      sender.send(wo, exp(-tau), at + j, p.padded);
    }
  }

  /// |mu| times the optical depth from y in a layer to the exit along w_o.
  [[gnu::noinline]] Floats depth_to_exit(int layer, float y, bool up, Vec3<Floats> wo) const {
    const auto& numbers = *t.walk.layers;
    const auto area = [&](int k) LAMELLA_INLINE_LAMBDA {
      const OneLayer<Floats> at{numbers, k};
      if (numbers.value[kWidth][k] > 0) return VmfOnLanes<Floats>(at).sigma(-wo);
      return projected_area(SggxOnLanes<Floats, SggxMatrix>(at).a, -wo);
    };
    Floats sum(0);
    if (layer < t.walk.layer_count)
      sum = area(layer) * Floats(up ? y : numbers.value[kDepth][layer] - y);
    for (int k = up ? layer - 1 : layer + 1; k >= 0 && k < t.walk.layer_count; k += up ? -1 : 1)
      sum = multiply_add(area(k), Floats(numbers.value[kDepth][k]), sum);
    return sum;
  }

  /// Where the numbers of an event's directions stand in the scratch.
  struct Scratch {
    int padded_rows, columns;
    float *mus, *inverses, *densities, *sines, *attenuations, *cosines, *phi_sines;
    LAMELLA_INLINE explicit Scratch(const LaneCells& cells)
        : padded_rows((cells.rows + 15) / 16 * 16),
          columns(cells.padded_columns),
          mus(cells.scratch),
          inverses(mus + padded_rows),
          densities(inverses + padded_rows),
          sines(densities + padded_rows),
          attenuations(sines + padded_rows),  // two of them
          cosines(attenuations + 2 * padded_rows),
          phi_sines(cosines + columns) {}
  };

  [[gnu::noinline]] void aim(int layer, float y, float u_mu, float turn_cos, float turn_sin) const {
    const LaneCells& cells = t.cells;
    const Scratch to(cells);
    const int sides = cells.both_sides ? 2 : 1;
    const Floats rows(cells.rows), inverse_rows(1.0f / cells.rows);
    for (int r = 0; r < cells.rows; r += kLanes) {
      const Floats row = to_floats(Words::iota() + Words(r));
      Floats mu2 = max((rows - row - Floats(u_mu)) * inverse_rows, Floats(1e-9f));
      Floats inverse = reciprocal_sqrt(mu2), mu = mu2 * inverse, per_density = inverse;
      if (t.walk.lattice != nullptr) {
        // At grazing uniform in mu, by the weight 2 mu / mu(edge): nothing grows like 1 / mu.
        const FloatMask grazing = row > rows - Floats(1.5f);
        const Floats share = max(Floats(1.0f - u_mu), Floats(1e-6f)), edge = sqrt(inverse_rows);
        mu = select(grazing, share * edge, mu);
        mu2 = select(grazing, mu * mu, mu2);
        inverse = select(grazing, reciprocal(mu), inverse);
        per_density = select(grazing, Floats(2) * reciprocal(edge), inverse);
      }
      const Floats sine = sqrt(nonnegative(Floats(1) - mu2));
      mu.store(to.mus + r);
      inverse.store(to.inverses + r);
      per_density.store(to.densities + r);
      sine.store(to.sines + r);
      for (int side = 0; cells.symmetric && side < sides; ++side) {
        const Vec3<Floats> wo{sine, Floats(0), side ? -mu : mu};
        const Floats tau = depth_to_exit(layer, y, side == 0, wo) * inverse;
        (exp(-tau) * per_density).store(to.attenuations + side * to.padded_rows + r);
      }
    }
    for (int j = 0; j < to.columns; j += kLanes) {
      const Floats c = Floats::load(cells.column_cos + j), s = Floats::load(cells.column_sin + j);
      (c * Floats(turn_cos) - s * Floats(turn_sin)).store(to.cosines + j);
      (s * Floats(turn_cos) + c * Floats(turn_sin)).store(to.phi_sines + j);
    }
  }

  template <class M>
  LAMELLA_INLINE void to_cells(const Sender<M>& sender, std::uint32_t slot, float y) const {
    const LaneCells& cells = t.cells;
    const Scratch from(cells);
    const int sides = cells.both_sides ? 2 : 1, columns = from.columns;
    const int places = sides * cells.rows * columns;
    std::int64_t* at = sender.targets + static_cast<int>(slot) * t.channels * places;
    for (int side = 0; side < sides; ++side)
      for (int r = 0; r < cells.rows; ++r, at += columns) {
        const Floats sine(from.sines[r]), z(side ? -from.mus[r] : from.mus[r]);
        const Floats inverse(from.inverses[r]), per_density(from.densities[r]);
        const Floats attenuation(from.attenuations[side * from.padded_rows + r]);
        for (int j = 0; j < columns; j += kLanes) {
          const Vec3<Floats> wo{sine * Floats::load(from.cosines + j),
                                sine * Floats::load(from.phi_sines + j), z};
          Floats a = attenuation;
          if (!cells.symmetric)
            a = exp(-(depth_to_exit(sender.layer, y, side == 0, wo) * inverse)) * per_density;
          sender.send(wo, a, at + j, places);
        }
      }
  }
};

}  // namespace lamella::LAMELLA_ISA
