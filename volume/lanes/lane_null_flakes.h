#pragma once

// Number types: as lane_media.h. Domain: mean normal z or -z, alpha as takes_null_collisions has
// it. Error: cumulative probabilities of the tables within 2e-6 of the distributions' own.
//
// vMF flakes of counted walks, which take normals by null collisions: flight by the majorant of
// sigma that VisibleNormalMixture (phase/medium/vmf_mixture.h) has, a normal from one of its two
// proposals by a marginal distribution that a table inverts (volume/lanes/lane_marginals.h), and a
// refused normal is a collision that does not count. What is refused is the majorant less sigma: at
// most 0.3 of it from the front. A step takes less than half the time of one of VmfOnLanes, with 4
// KiB of a table for each proposal; but the refusals leave less to lattices, which next-event
// estimation gains more by than it would by the time.

#include "phase/medium/vmf_mixture.h"
#include "volume/lanes/lane_media.h"

namespace lamella {

template <class Real>
struct RefusableEvent : LaneEvent<Real> {
  MaskOf<Real> accepted;
};

template <class Real>
struct NullVmfOnLanes {
  static constexpr bool kNull = true;
  using Mask = MaskOf<Real>;
  using Words = WordsOf<Real>;
  Real up;  ///< 1 where the mean normal points up, -1 where down
  VisibleNormalMixture<Real> mixture;
  Words first_piece;
  const float* tables;
  template <class Reader>
  LAMELLA_INLINE explicit NullVmfOnLanes(const Reader& n)
      : up(n(kAxis + 2)),
        mixture{n(kFront), n(kBack), n(kSide)},
        first_piece(word_of(n(kTable))),
        tables(n.numbers.tables) {}

  LAMELLA_INLINE Real inverse_area(Vec3<Real> w) const {
    using std::sqrt;
    const Real s = sqrt(multiply_add(w.x, w.x, w.y * w.y));
    // Nothing faces the light that comes straight from behind narrow flakes.
    return reciprocal(max(mixture.majorant(up * w.z, s), Real(1e-30)));
  }
  /// The cubic of a table, x in [0, kMarginalPieces).
  LAMELLA_INLINE Real tabulated(Words table, Real x) const {
    const Words piece = word_of(x);
    const Real t = x - number_of(piece);
    const Words at = shift_left<2>(first_piece + table + piece);
    const auto low = gather_pair(tables, at), high = gather_pair(tables + 2, at);
    Real value = multiply_add(t, high.second, high.first);
    value = multiply_add(t, value, low.second);
    return multiply_add(t, value, low.first);
  }
  /// A normal, and whether it is accepted, from four words.
  LAMELLA_INLINE RefusableEvent<Real> collide(Vec3<Real> wi, const Words* words) const {
    using std::cbrt, std::sqrt;
    const Real u = up * wi.z, s2 = multiply_add(wi.x, wi.x, wi.y * wi.y);
    const Real inverse_s = reciprocal_sqrt(max(s2, Real(1e-10))), s = s2 * inverse_s;
    const Mask at_pole = s2 < Real(1e-10), behind = u < Real(0);
    const Real tangent_x = select(at_pole, Real(1), inverse_s * wi.x);
    const Real tangent_y = select(at_pole, Real(0), inverse_s * wi.y);
    const Mask is_axial = uniform_of(words[1]) * mixture.majorant(u, s) < mixture.axial(u);
    // 1 - the cosine with the axis, by cubics in t: the root or cube root of an exponential number.
    const Real e = max(exponential_of(words[2]) * Real(1 / kLargestExponential), Real(1e-20));
    const Real t = select(is_axial, sqrt(e), cbrt(e));
    const auto table = [](unsigned n) { return Words(n * kMarginalPieces); };
    const auto word_mask = [](Mask m) { return to_word_mask(m); };
    const Words which =
        select(word_mask(is_axial), select(word_mask(behind), table(1), table(0)), table(2));
    const Real below =
        tabulated(which, min(t * Real(kMarginalPieces), Real(kMarginalPieces - 1e-3)));
    const Vec3<Real> m = proposed_normal<Real>(is_axial, below, signed_uniform_of(words[3]));
    return {{wi,
             {m.x * tangent_x - m.y * tangent_y, m.x * tangent_y + m.y * tangent_x, up * m.z},
             Real(1)},
            takes_visible_normal(u, s, m, uniform_of(words[4]))};
  }
};

template <class Real>
struct NullVmfLambertOnLanes : NullVmfOnLanes<Real> {
  static constexpr auto kKind = LaneMediumKind::vmf_lambert;
  static constexpr bool kDiffuse = true, kMirror = false;
  static constexpr int kWords = 7;
  using NullVmfOnLanes<Real>::NullVmfOnLanes;
  LAMELLA_INLINE LaneScatter<Real> sample(const LaneEvent<Real>& e,
                                          const WordsOf<Real>* words) const {
    return {next_by_lambert(e.normal, words + 5), Real(1)};
  }
};

template <class Real>
struct NullVmfMirrorOnLanes : NullVmfOnLanes<Real> {
  static constexpr auto kKind = LaneMediumKind::vmf_mirror;
  static constexpr bool kDiffuse = false, kMirror = true;
  static constexpr int kWords = 5;
  using NullVmfOnLanes<Real>::NullVmfOnLanes;
  LAMELLA_INLINE LaneScatter<Real> sample(const LaneEvent<Real>& e, const WordsOf<Real>*) const {
    return mirrored(e);
  }
};

}  // namespace lamella
