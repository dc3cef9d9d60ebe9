#pragma once

// The media on lanes: the formulas of phase with lanes of float. Only for sources of
// lamella_lanes(). A medium here has
//   kNull: whether `collide` may refuse (a null collision, flight being by a majorant of sigma);
//   kWords: blocks of random words per event;
//   inverse_area(w): 1 / sigma(w), or of its majorant;
//   collide(wi, words): the event, with `accepted` where kNull;
//   sample(event, words): w_o; density(event, w_o): p, or its estimate given the event.
// words[0].w[0] is left for the free flight.

#include "phase/lane_formulas.h"
#include "phase/lane_random.h"
#include "volume/lane_walk.h"

namespace lamella::LAMELLA_ISA {

using Direction16 = FloatVector;

LAMELLA_INLINE Direction16 broadcast(const float* w) {
  return {Floats(w[0]), Floats(w[1]), Floats(w[2])};
}

/// p of Lambert spheres: sin theta - theta cos theta = x^3 P(x^2), x^2 = 1 - |cos theta|, plus
/// -pi cos theta behind the horizon; P by a Chebyshev series. Absolute error below 3e-8 / sr.
LAMELLA_INLINE Floats lambert_sphere_phase(Floats cosine) {
  const Floats z = nonnegative(Floats(1) - abs(cosine));
  Floats p = multiply_add(z, Floats(2.380421156e-4f), Floats(-1.867968235e-4f));
  p = multiply_add(z, p, Floats(7.540276669e-4f));
  p = multiply_add(z, p, Floats(1.652281571e-3f));
  p = multiply_add(z, p, Floats(7.594096005e-3f));
  p = multiply_add(z, p, Floats(4.713927958e-2f));
  p = multiply_add(z, p, Floats(9.428090540e-1f));
  const Floats front = z * sqrt(z) * p;
  return Floats(2 / (3 * kPi * kPi)) * multiply_add(nonnegative(-cosine), Floats(kPi), front);
}

struct LaneLambertSphere {
  static constexpr bool kNull = false;
  static constexpr int kWords = 1;
  struct Event {
    Direction16 wi;
    static constexpr int kNumbers = 3;
    LAMELLA_INLINE void store(float* to) const {
      wi.x.store(to), wi.y.store(to + Floats::kCount), wi.z.store(to + 2 * Floats::kCount);
    }
    LAMELLA_INLINE static Event broadcast_from(const float* from, int lane) {
      constexpr int n = Floats::kCount;
      return {{Floats(from[lane]), Floats(from[n + lane]), Floats(from[2 * n + lane])}};
    }
  };
  LAMELLA_INLINE explicit LaneLambertSphere(const LaneMediumNumbers&) {}
  LAMELLA_INLINE Floats inverse_area(Direction16) const { return Floats(1); }
  LAMELLA_INLINE Event collide(Direction16 wi, const WordBlock*) const { return {wi}; }
  LAMELLA_INLINE Direction16 sample(const Event& e, const WordBlock* words) const {
    const Words* w = words[0].w;
    const Floats cosine =
        lambert_sphere_cosine(uniform_of(w[1]), uniform_of(w[2]), uniform_of(w[3]));
    return deflect(-e.wi, cosine, uniform_of_rest(w[1], w[2], w[3]));
  }
  LAMELLA_INLINE Floats density(const Event& e, Direction16 wo) const {
    return isa_phase(-dot(e.wi, wo));
  }
  LAMELLA_INLINE static Floats isa_phase(Floats c) { return LAMELLA_ISA::lambert_sphere_phase(c); }
};

struct LaneHenyeyGreenstein {
  static constexpr bool kNull = false;
  static constexpr int kWords = 1;
  using Event = LaneLambertSphere::Event;
  Floats g;
  LAMELLA_INLINE explicit LaneHenyeyGreenstein(const LaneMediumNumbers& n) : g(n.g) {}
  LAMELLA_INLINE Floats inverse_area(Direction16) const { return Floats(1); }
  LAMELLA_INLINE Event collide(Direction16 wi, const WordBlock*) const { return {wi}; }
  LAMELLA_INLINE Direction16 sample(const Event& e, const WordBlock* words) const {
    const Words* w = words[0].w;
    return deflect(-e.wi, henyey_greenstein_cosine(g, uniform_of(w[1])), uniform_of(w[2]));
  }
  LAMELLA_INLINE Floats density(const Event& e, Direction16 wo) const {
    return henyey_greenstein_phase(g, -dot(e.wi, wo));
  }
};

/// A flake that reflects by Lambert's law, its normal drawn.
struct LaneNormalEvent {
  Direction16 normal;
  static constexpr int kNumbers = 3;
  LAMELLA_INLINE void store(float* to) const { LaneLambertSphere::Event{normal}.store(to); }
  LAMELLA_INLINE static LaneNormalEvent broadcast_from(const float* from, int lane) {
    return {LaneLambertSphere::Event::broadcast_from(from, lane).wi};
  }
  LAMELLA_INLINE Floats density(Direction16 wo) const {
    return nonnegative(dot(normal, wo)) * Floats(1 / kPi);
  }
};

struct LaneSggxLambert {
  static constexpr bool kNull = false;
  static constexpr int kWords = 1;
  using Event = LaneNormalEvent;
  LaneMatrix a;
  LAMELLA_INLINE explicit LaneSggxLambert(const LaneMediumNumbers& n) : a(n.a) {}
  LAMELLA_INLINE Floats inverse_area(Direction16 w) const {
    const Direction16 v = a.apply_transposed(w);
    return reciprocal_sqrt(dot(v, v));
  }
  LAMELLA_INLINE Event collide(Direction16 wi, const WordBlock* words) const {
    return {visible_normal(a, wi, uniform_of(words[0].w[1]), uniform_of(words[0].w[2]))};
  }
  LAMELLA_INLINE Direction16 sample(const Event& e, const WordBlock* words) const {
    const Words* w = words[0].w;
    return cosine_hemisphere(e.normal, uniform_of(w[3]), uniform_of_rest(w[1], w[2], w[3]));
  }
  LAMELLA_INLINE Floats density(const Event& e, Direction16 wo) const { return e.density(wo); }
};

struct LaneSggxMirror {
  static constexpr bool kNull = false;
  static constexpr int kWords = 1;
  struct Event {
    Direction16 wi;
    Floats inverse_sigma;
    static constexpr int kNumbers = 4;
    LAMELLA_INLINE void store(float* to) const {
      LaneLambertSphere::Event{wi}.store(to);
      inverse_sigma.store(to + 3 * Floats::kCount);
    }
    LAMELLA_INLINE static Event broadcast_from(const float* from, int lane) {
      return {LaneLambertSphere::Event::broadcast_from(from, lane).wi,
              Floats(from[3 * Floats::kCount + lane])};
    }
  };
  LaneMatrix a, inverse;
  Floats density_scale;
  LAMELLA_INLINE explicit LaneSggxMirror(const LaneMediumNumbers& n)
      : a(n.a), inverse(n.inverse), density_scale(n.density_scale) {}
  LAMELLA_INLINE Floats inverse_area(Direction16 w) const {
    const Direction16 v = a.apply_transposed(w);
    return reciprocal_sqrt(dot(v, v));
  }
  LAMELLA_INLINE Event collide(Direction16 wi, const WordBlock*) const {
    return {wi, inverse_area(wi)};
  }
  LAMELLA_INLINE Direction16 sample(const Event& e, const WordBlock* words) const {
    const Words* w = words[0].w;
    return mirrored(e.wi, visible_normal(a, e.wi, uniform_of(w[1]), uniform_of(w[2])));
  }
  /// D(h) / (4 sigma(w_i)), D as in normal_density with u = A^-1 h.
  LAMELLA_INLINE Floats density(const Event& e, Direction16 wo) const {
    const Direction16 h = e.wi + wo;
    const Direction16 u = inverse.apply(h);
    const Floats ratio = dot(h, h) * reciprocal(max(dot(u, u), Floats(1e-30f)));
    return ratio * ratio * density_scale * e.inverse_sigma;
  }
};

/// vMF flakes: flight by the majorant |u| sigma(+-1) + sin sigma(0) of sigma, normals from the
/// mixture of phase/vmf.cpp, whose acceptance is sigma over that majorant: at least 0.7 from the
/// front.
struct LaneVmf {
  static constexpr bool kNull = true;
  static constexpr int kWords = 2;
  Direction16 axis, tangent_at_pole;
  Floats front, back, side;
  const float* marginals;
  LAMELLA_INLINE explicit LaneVmf(const LaneMediumNumbers& n)
      : axis(broadcast(n.axis)),
        tangent_at_pole(frame_around(axis).s),
        front(n.front),
        back(n.back),
        side(n.side),
        marginals(n.marginals) {}

  struct View {  // of a direction in the frame of the axis
    Floats u, s;
    Direction16 tangent;
  };
  LAMELLA_INLINE View view(Direction16 w) const {
    const Floats u = dot(w, axis);
    const Direction16 across = w - u * axis;
    const Floats s2 = dot(across, across);
    const FloatMask pole = s2 < Floats(1e-10f);
    const Floats inverse_s = reciprocal_sqrt(max(s2, Floats(1e-10f)));
    return {u, s2 * inverse_s, select(pole, tangent_at_pole, inverse_s * across)};
  }
  LAMELLA_INLINE Floats inverse_area(Direction16 w) const {
    const Floats u = dot(w, axis);
    const Direction16 across = w - u * axis;
    const Floats s = sqrt(dot(across, across));
    const Floats axial = abs(u) * select(u < Floats(0), back, front);
    return reciprocal(multiply_add(s, side, axial));
  }
  struct Draw {
    Direction16 normal;
    FloatMask accepted;
  };
  LAMELLA_INLINE Draw draw(Direction16 wi, const WordBlock* words) const {
    const View v = view(wi);
    const FloatMask behind = v.u < Floats(0);
    const Floats axial = abs(v.u) * select(behind, back, front),
                 total = multiply_add(v.s, side, axial);
    const FloatMask is_axial = uniform_of(words[0].w[1]) * total < axial;
    // 1 - the cosine with the axis, by cubics in t: t^2 or t^3 of the (folded) uniform number.
    const Floats xi = uniform_of(words[0].w[2]);
    const FloatMask upper = xi > Floats(0.5f);
    const Floats folded = Floats(2) * min(xi, Floats(1) - xi);
    const Floats t = select(is_axial, sqrt(xi), exp(log(folded) * Floats(1.0f / 3)));
    const Floats scaled = min(t * Floats(kMarginalPieces), Floats(kMarginalPieces - 0.001f));
    const Words piece = to_words(scaled);
    const Floats x = scaled - to_floats(piece);
    const auto table = [](float n) { return Floats(n * kMarginalPieces); };
    const Floats which =
        select(is_axial, select(behind, table(1), table(0)), select(upper, table(3), table(2)));
    const Words at = shift_left<2>(piece + to_words(which));
    Floats below = multiply_add(x, gather(marginals + 3, at), gather(marginals + 2, at));
    below = multiply_add(x, below, gather(marginals + 1, at));
    below = multiply_add(x, below, gather(marginals, at));
    const Floats r = sqrt(nonnegative(below * (Floats(2) - below))), z = Floats(1) - below;
    const Floats u3 = uniform_of(words[0].w[3]);
    const auto [sine, cosine] = sine_cosine_of_turns(u3);
    const Floats flat = multiply_add(Floats(2), u3, Floats(-1));
    const Floats sin_phi = select(is_axial, sine, flat);
    const Floats cos_phi =
        select(is_axial, cosine, sqrt(nonnegative((Floats(1) - flat) * (Floats(1) + flat))));
    const Floats mx = r * cos_phi, my = r * sin_phi;
    const Floats projected = multiply_add(v.u, z, v.s * mx);
    const Floats bound =
        multiply_add(abs(v.u), nonnegative(select(behind, -z, z)), v.s * nonnegative(mx));
    return {renormalized(mx * v.tangent + my * cross(axis, v.tangent) + z * axis),
            uniform_of(words[1].w[0]) * bound < projected};
  }
};

struct LaneVmfLambert : LaneVmf {
  using LaneVmf::LaneVmf;
  struct Event : LaneNormalEvent {
    FloatMask accepted;
    LAMELLA_INLINE static Event broadcast_from(const float* from, int lane) {
      return {LaneNormalEvent::broadcast_from(from, lane), first_lanes<float>(Floats::kCount)};
    }
  };
  LAMELLA_INLINE Event collide(Direction16 wi, const WordBlock* words) const {
    const Draw d = draw(wi, words);
    return {{d.normal}, d.accepted};
  }
  LAMELLA_INLINE Direction16 sample(const Event& e, const WordBlock* words) const {
    return cosine_hemisphere(e.normal, uniform_of(words[1].w[1]), uniform_of(words[1].w[2]));
  }
  LAMELLA_INLINE Floats density(const Event& e, Direction16 wo) const {
    return e.LaneNormalEvent::density(wo);
  }
};

struct LaneVmfMirror : LaneVmf {
  using LaneVmf::LaneVmf;
  struct Event : LaneNormalEvent {
    FloatMask accepted;
    Direction16 wi;
  };
  LAMELLA_INLINE Event collide(Direction16 wi, const WordBlock* words) const {
    const Draw d = draw(wi, words);
    return {{d.normal}, d.accepted, wi};
  }
  LAMELLA_INLINE Direction16 sample(const Event& e, const WordBlock*) const {
    return mirrored(e.wi, e.normal);
  }
};

}  // namespace lamella::LAMELLA_ISA
