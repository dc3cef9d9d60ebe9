#pragma once

// Boundaries as walks on lanes meet them: smooth and rough interfaces in single scattering. A
// template over the number type, like volume/lanes/lane_step.h.

#include "phase/surface/fresnel_formulas.h"
#include "phase/surface/microfacet_formulas.h"
#include "volume/lanes/lane_step.h"

namespace lamella {

/// Rows of BoundaryNumbers.
enum BoundaryField {
  kShape,    ///< 0: no interface, else 1 + FacetShape
  kMasking,  ///< Masking
  kAlphaX,   ///< of rough ones
  kAlphaY,
  kRatioDown,   ///< index below over index above: for light from above
  kExcessDown,  ///< its square less 1
  kRatioUp,     ///< the same for light from below
  kExcessUp,
  kBoundaryFields
};

/// The boundaries of a stack: k above layer k, the last one below all layers.
template <class Scalar>
struct BoundaryNumbers {
  Scalar value[kBoundaryFields][kMostLaneLayers] = {};
  bool smooth = false, rough = false;  ///< there are some
  bool ggx = false, beckmann = false;
  bool beta = false, separable = false;  ///< Masking of rough ones
  int only = -1;                         ///< the place of the interface if there is one alone
  /// Words that light at a boundary takes, that of the next free flight first.
  int words = 2;  // kSmoothWords
};
inline constexpr int kSmoothWords = 2, kGgxWords = 6, kBeckmannWords = 8;
inline constexpr int kMostBoundaryWords = kBeckmannWords;
/// Layers of stacks with interfaces, whose boundaries are one more.
inline constexpr int kMostBoundedLayers = kMostLaneLayers - 1;

/// LaneState::layer of a walk at boundary k.
inline constexpr std::uint32_t kAtBoundary = 32;
/// Boundaries that light meets between two events until the walk is cut.
inline constexpr std::uint32_t kMostMeetings = 1 << 20;

/// Walks through boundaries, one per lane.
template <class Real, int C>
struct BoundedState : LaneState<Real, C> {
  WordsOf<Real> met;  ///< twice the boundaries met since the last event, and 1 if one was rough
};

/// AnyMedia between boundaries, at which flights end.
template <class Real>
struct BoundedMedia : AnyMedia<Real> {
  static constexpr bool kBounded = true, kCountsSteps = true;
  using Base = AnyMedia<Real>;
  using Scalar = typename Base::Scalar;
  using Mask = MaskOf<Real>;
  using Words = WordsOf<Real>;
  using Flight = typename Base::Flight;
  using Base::count, Base::t;

  LAMELLA_INLINE explicit BoundedMedia(const WalkSetting<Scalar>& setting) : Base(setting) {}

  [[nodiscard]] LAMELLA_INLINE Mask is_at_boundary(Words layer) const {
    return !to_float_mask(is_below(layer & Words(2 * kAtBoundary - 1), Words(kAtBoundary)));
  }
  /// Through one layer, or to a collision in it, or to an interface; whether any lane flies on.
  /// `collides` are the lanes that met one of them.
  LAMELLA_INLINE bool cross(Flight& f, Vec3<Real> wi, Words& layer, Real& y) const {
    const Real inverse = this->inverse_area(layer, wi),
               depth = lookup(t.layers->value[kDepth], layer);
    if (!Base::flies_past(f, inverse, depth, wi, y)) return false;
    const auto down_words = to_word_mask(f.down), fly_words = to_word_mask(f.flies);
    const Words boundary = select(down_words, layer + Words(1u), layer);
    const Mask stops = f.flies & (lookup(t.boundaries->value[kShape], boundary) > Real(0));
    f.collides = f.collides | stops;
    f.flies = without(f.flies, stops);
    const Words beyond = select(down_words, boundary, layer - Words(1u));
    layer = select(to_word_mask(stops), boundary + Words(kAtBoundary),
                   select(fly_words, beyond, layer));
    if (!any(f.flies)) return false;
    this->spend(f, inverse, depth, y);
    if (t.substrate) f.collides = f.collides | (f.flies & to_float_mask(equal(layer, count)));
    f.flies = f.flies & to_float_mask(layer < count);
    y = select(f.flies, select(f.down, Real(0), lookup(t.layers->value[kDepth], layer)), y);
    return any(f.flies);
  }
  /// Through a stack without media: which of the lanes `flies` reach an interface or the substrate.
  LAMELLA_INLINE Mask hop(Vec3<Real> wi, Mask flies, Words& layer) const {
    const auto down = to_word_mask(wi.z > Real(0));
    const Words boundary = select(down, layer + Words(1u), layer);
    const Mask stops = flies & (lookup(t.boundaries->value[kShape], boundary) > Real(0));
    const Words next = select(to_word_mask(stops), boundary + Words(kAtBoundary), boundary);
    layer = select(to_word_mask(flies), next, layer);
    return t.substrate ? stops | (flies & to_float_mask(equal(layer, count))) : stops;
  }
  /// Whether light meets an interface as it enters: then `layer` is where that is.
  LAMELLA_INLINE bool enters_at_boundary(Words& layer) const {
    const int entry = t.from_above ? 0 : t.layer_count;
    layer = Words(kAtBoundary + static_cast<std::uint32_t>(entry));
    return t.boundaries->value[kShape][entry] > 0;
  }
  /// From outside, or from an event: which lanes meet something.
  LAMELLA_INLINE Mask fly(Vec3<Real> wi, Real remaining, Mask flies, Words& layer, Real& y) const {
    Flight flight = this->begin_flight(wi, remaining, flies, layer, y);
    while (cross(flight, wi, layer, y)) {
    }
    return flight.collides;
  }
};

/// What became of light at boundaries.
template <class Real>
struct BoundaryEnds {
  MaskOf<Real> lives;  ///< flies on in a layer, or reaches the substrate
  MaskOf<Real> lost, out, cut;
};

/// Where light comes from that meets an interface.
enum class InterfaceSide { above, below, any };

/// What meet() knows of the boundaries when it is compiled: nothing.
struct AnyBoundaries {
  static constexpr bool kOne = false;
  static constexpr InterfaceSide kFrom = InterfaceSide::any;
  bool smooth, rough, ggx, beckmann, beta, separable;
  template <class Scalar>
  explicit AnyBoundaries(const BoundaryNumbers<Scalar>& b)
      : smooth(b.smooth),
        rough(b.rough),
        ggx(b.ggx),
        beckmann(b.beckmann),
        beta(b.beta),
        separable(b.separable) {}
};

/// One GGX interface above everything else, with Masking::beta or Masking::correlated. Its meetings
/// leave layer, y and met of walks to who calls.
template <InterfaceSide kSide, bool kBeta>
struct OneGgxBoundary {
  static constexpr bool kOne = true, smooth = false, rough = true, ggx = true, beckmann = false,
                        beta = kBeta, separable = false;
  static constexpr InterfaceSide kFrom = kSide;
  static constexpr int kWords = kBeta ? kGgxWords : kGgxWords - 1;
  template <class Scalar>
  explicit OneGgxBoundary(const BoundaryNumbers<Scalar>&) {}
  template <class Scalar>
  [[nodiscard]] static bool describes(const BoundaryNumbers<Scalar>& b) {
    return b.only == 0 && b.ggx && b.beta == kBeta && !b.separable && b.words == kWords;
  }
};
template <InterfaceSide kSide>
using BetaGgx = OneGgxBoundary<kSide, true>;
template <InterfaceSide kSide>
using CorrelatedGgx = OneGgxBoundary<kSide, false>;

/// Whether facets let light pass that one of them has sent on. The chances are 1 / (1 + c), c = L_o
/// / (1 + L_i), or L_o with Masking::separable: one uniform number tells. With Masking::beta
/// somewhere two exponential numbers do, whose laws are those of Smith's heights: of light from w_i
/// the facet is met at a height with cumulative u, density a u^(a - 1), a = 1 + L_i; from there
/// light reaches the outside along w_o above with the chance u^L_o, below the surface with (1 -
/// u)^L_o. The means are the masking functions of Masking::beta.
template <class Real, class Kind>
[[nodiscard]] LAMELLA_INLINE MaskOf<Real> passes_facets(const Kind& kind, Real masking,
                                                        MaskOf<Real> below, Real wi_z, Real seen,
                                                        Real wo_z, Real hidden,
                                                        const WordsOf<Real>* words) {
  using std::exp;
  // c = hides / shows
  Real shows = seen * wo_z, hides = hidden * wi_z;
  if (kind.separable) {
    const auto apart = masking > Real(1.5);
    shows = select(apart, wo_z, shows);
    hides = select(apart, hidden, hides);
  }
  if (!kind.beta) return fine_uniform_of(words[0]) * (shows + hides) < shows;
  const Real e1 = exponential_of(words[0]), e2 = exponential_of(words[1]);
  const auto passes = e2 * shows > hides * e1;
  // u = exp(-x), and 1 - u without cancellation
  const Real x = divide(wi_z * e1, seen);
  const Real series = x * multiply_add(x, multiply_add(x, Real(1.0 / 6), Real(-0.5)), Real(1));
  const Real beyond = select(x < Real(0.03), series, Real(1) - exp(-x));
  const auto through = beyond > exp(-divide(e2 * wo_z, max(hidden, Real(1e-30))));
  const auto asks = below & (masking < Real(0.5));
  return without(passes, asks) | (asks & through);
}

/// The words of a meeting of the lanes `meets` with an interface: a step of its own.
template <class Real, int C>
LAMELLA_INLINE void draw_meeting(const WalkSetting<typename NumberTraits<Real>::Scalar>& t,
                                 int count, MaskOf<Real> meets, LaneState<Real, C>& w,
                                 WordsOf<Real>* words) {
  using Words = WordsOf<Real>;
  for (int j = 0; j < count; ++j) words[j] = w.numbers.next();
  if (t.lattice == nullptr) return;
  const auto early = is_below(w.step, Words(kLatticeSteps));
  for (int j = 0; j < count; ++j)
    words[j] = select(early, lattice_word(*t.lattice, j, w.step, w.point, w.shift), words[j]);
  w.step = w.step + select(to_word_mask(meets), Words(1u), Words(0u));
}

/// Light of the lanes `active`, all at boundaries: reflected or refracted by chance, and perhaps
/// lost. words[0] is left to the flight that follows. Kind: AnyBoundaries, or what is known of
/// them.
template <class Kind, class Real, int C>
LAMELLA_INLINE BoundaryEnds<Real> meet(const WalkSetting<typename NumberTraits<Real>::Scalar>& t,
                                       BoundedState<Real, C>& w, const WordsOf<Real>* words,
                                       MaskOf<Real> active) {
  using Mask = MaskOf<Real>;
  using Words = WordsOf<Real>;
  const auto& b = *t.boundaries;
  const Kind kind(b);
  const Words at = Kind::kOne ? Words(0u) : w.layer & Words(kAtBoundary - 1);
  const auto number = [&](int field) LAMELLA_INLINE_LAMBDA {
    if (Kind::kOne) return Real(b.value[field][0]);
    return b.only < 0 ? lookup(b.value[field], at) : Real(b.value[field][b.only]);
  };
  // Facets of both sides are the same turned by pi about z.
  Mask from_below = w.wi.z < Real(0);
  if (Kind::kFrom == InterfaceSide::above) from_below = without(from_below, from_below);
  if (Kind::kFrom == InterfaceSide::below) from_below = every_lane<Real>();
  const Vec3<Real> v = select(from_below, -w.wi, w.wi);
  const Real ratio_up = number(kRatioUp), ratio_down = number(kRatioDown);
  const Real ratio = select(from_below, ratio_up, ratio_down);
  const Real inverse = select(from_below, ratio_down, ratio_up);
  const Real excess = select(from_below, number(kExcessUp), number(kExcessDown));
  const Mask none = without(active, active);
  const Mask smooth = kind.rough ? (kind.smooth ? number(kShape) < Real(1.5) : none) : active;

  Vec3<Real> m{Real(0), Real(0), Real(1)};
  Real seen(1);
  const GgxFacets<Real> ggx{number(kAlphaX), number(kAlphaY)};
  const BeckmannFacets<Real> beckmann{ggx.alpha_x, ggx.alpha_y};
  const Mask is_beckmann = kind.beckmann ? number(kShape) > Real(2.5) : none;
  if (kind.rough) {
    if (kind.ggx) {
      const auto visible = ggx.visible(v, azimuth_of(words[1]), fine_uniform_of(words[2]));
      m = visible.m;
      seen = visible.seen;
    }
    if (kind.beckmann) {
      const auto slopes = beckmann.seen_by(v);
      const Vec3<Real> n =
          beckmann.visible_normal(slopes, azimuth_of(words[1]), exponential_of(words[2]),
                                  fine_uniform_of(words[6]), fine_uniform_of(words[7]));
      m = select(is_beckmann, n, m);
      seen = select(is_beckmann, v.z + beckmann.hidden_area(slopes), seen);
    }
    if (kind.smooth) m = select(smooth, Vec3<Real>{Real(0), Real(0), Real(1)}, m);
  }
  const Real cosine = nonnegative(dot(v, m));
  const Refraction<Real> r = refraction(cosine, ratio, inverse, excess);
  const Mask refracts =
      without(r.cosine > Real(0), fine_uniform_of(words[kind.rough ? 3 : 1]) < r.reflectance);
  // Both are along m and v.
  const Real along_m = select(refracts, multiply_add(inverse, cosine, -r.cosine), cosine + cosine);
  const Real along_v = select(refracts, -inverse, Real(-1));
  Vec3<Real> wo = along_m * m + along_v * v;
  if (kind.smooth) wo.z = select(smooth, select(refracts, -r.cosine, v.z), wo.z);
  wo = renormalized(wo);

  Mask lost = none;
  if (kind.rough) {
    using std::abs;
    const Real z = max(abs(wo.z), Real(1e-30));
    Real hidden(0);
    if (kind.ggx) hidden = ggx.hidden_area({wo.x, wo.y, z});
    if (kind.beckmann)
      hidden = select(is_beckmann, beckmann.hidden_area(Vec3<Real>{wo.x, wo.y, z}), hidden);
    const Mask passes =
        passes_facets(kind, kind.beta || kind.separable ? number(kMasking) : Real(1), refracts, v.z,
                      seen, z, hidden, words + 4);
    const Mask right = (refracts & (wo.z < Real(0))) | without(wo.z > Real(0), refracts);
    lost = without(without(active, smooth), passes & right);
  }
  w.wi = select(active, select(from_below, wo, -wo), w.wi);
  if constexpr (Kind::kOne) {
    const Mask up = w.wi.z < Real(0), out = without(active & up, lost);
    return {without(active, lost | up), lost, out, none};
  }
  Words met = w.met + Words(2u);
  met = select(to_word_mask(smooth), met, met | Words(1u));
  w.met = select(to_word_mask(active), met, w.met);

  const Mask down = w.wi.z > Real(0);
  const Words last(static_cast<std::uint32_t>(t.layer_count));
  const auto goes_down = to_word_mask(down), at_bottom = equal(at, last);
  const auto leaves_above = without(equal(at, Words(0u)), goes_down);
  const Mask leaves = active & to_float_mask((goes_down & at_bottom) | leaves_above);
  const Mask cut = active & to_float_mask(is_below(Words(2 * kMostMeetings), w.met));
  const Words layer = select(to_word_mask(down), at, at - Words(1u));
  w.layer = select(to_word_mask(active), layer, w.layer);
  w.y = select(active, select(down, Real(0), lookup(t.layers->value[kDepth], layer)), w.y);
  const Mask out = without(leaves, lost), ends = lost | leaves | cut;
  return {without(active, ends), lost, out, without(cut, lost | leaves)};
}

}  // namespace lamella
