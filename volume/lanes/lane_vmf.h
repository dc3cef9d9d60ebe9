#pragma once

// Number types: lanes of float, and double. Domain and error: those of volume/lanes/lane_normals.h
// and volume/lanes/lane_narrow_normals.h, which have the formulas and the symbols.
//
// Projected area and normals of vMF flakes as walks on lanes take them: what VmfMirrors and
// VmfLambertians (volume/lanes/lane_media.h) have in common.

#include "phase/math/vec3.h"
#include "phase/random/block_random.h"
#include "volume/lanes/lane_layers.h"
#include "volume/lanes/lane_narrow_normals.h"
#include "volume/lanes/lane_normals.h"

namespace lamella {

/// By tables.
template <class Real>
struct VmfOnLanes {
  using Mask = MaskOf<Real>;
  using Words = WordsOf<Real>;
  Vec3<Real> axis, across;  ///< across: some direction perpendicular to the axis
  Real kappa, mean;
  Real width, reach;  ///< 1 / sqrt(kappa + 1); 1 / min(1, kLargestBehind width)
  Words first_patch;
  const float* tables;
  template <class Reader>
  LAMELLA_INLINE explicit VmfOnLanes(const Reader& n)
      : axis{n(kAxis), n(kAxis + 1), n(kAxis + 2)},
        across{n(kAcross), n(kAcross + 1), n(kAcross + 2)},
        kappa(n(kKappa)),
        mean(n(kMean)),
        width(n(kWidth)),
        reach(n(kReach)),
        first_patch(word_of(n(kTable))),
        tables(n.numbers.tables) {}

  /// The coordinate of rows from behind, which sigma has, too.
  LAMELLA_INLINE Real row_from_behind(Real u) const {
    using std::abs, std::sqrt;
    const Real s = sqrt(nonnegative(multiply_add(-u, u, Real(1))));
    return abs(u) * reciprocal(Real(1) + s) * reach;
  }
  LAMELLA_INLINE Real sigma_of(Real u, Real row) const {
    using std::exp;
    const Real x = min(row * Real(kSigmaPieces), Real(kSigmaPieces - 1e-5));
    const Words piece = word_of(x);
    const Real t = x - number_of(piece);
    const Words at = shift_left<2>(shift_left<2>(first_patch) + piece);
    const auto low = gather_pair(tables, at), high = gather_pair(tables + 2, at);
    Real log = multiply_add(t, high.second, high.first);
    log = multiply_add(t, log, low.second);
    log = multiply_add(t, log, low.first);
    return multiply_add(nonnegative(u), mean, exp(-log));
  }
  /// sigma(w), relative error below 1e-5 where it is above 1e-30.
  LAMELLA_INLINE Real sigma(Vec3<Real> w) const {
    const Real u = dot(w, axis);
    return sigma_of(u, row_from_behind(u));
  }
  LAMELLA_INLINE Real inverse_area(Vec3<Real> w) const {
    // Nothing faces the light that comes straight from behind narrow flakes.
    return reciprocal(max(sigma(w), Real(1e-30)));
  }
  /// A sheet's bicubic patch at its coordinates in [0, 1].
  template <int rows, int columns>
  LAMELLA_INLINE Real patched(Words sheet, Real row, Real column) const {
    const Real x = min(row * Real(rows), Real(rows - 1e-5));
    const Real y = min(column * Real(columns), Real(columns - 1e-5));
    const Words i = word_of(x), j = word_of(y);
    const Real r = x - number_of(i), c = y - number_of(j);
    const Words at = shift_left<4>(sheet + i * Words(columns) + j);
    const auto across_columns = [&](int power) LAMELLA_INLINE_LAMBDA {
      const float* from = tables + 4 * power;
      const auto low = gather_pair(from, at), high = gather_pair(from + 2, at);
      Real value = multiply_add(c, high.second, high.first);
      value = multiply_add(c, value, low.second);
      return multiply_add(c, value, low.first);
    };
    Real value = multiply_add(r, across_columns(3), across_columns(2));
    value = multiply_add(r, value, across_columns(1));
    return multiply_add(r, value, across_columns(0));
  }
  /// An exponential number from all bits but the first: the second half of the words counts from
  /// its end.
  struct Half {
    Mask upper;
    Real exponential;
    LAMELLA_INLINE explicit Half(Words word)
        : upper(!to_float_mask(equal(word & Words(0x80000000u), Words(0u)))),
          exponential(exponential_of(
              shift_left<1>(select(to_word_mask(upper), word ^ Words(0xFFFFFFFFu), word)))) {}
    /// Its column.
    LAMELLA_INLINE Real column() const {
      using std::sqrt;
      const double start = std::sqrt(kColumnStart);
      const double scale = 1 / (std::sqrt(kLargestExponential + kColumnStart) - start);
      return multiply_add(sqrt(exponential + Real(kColumnStart)), Real(scale),
                          Real(-start * scale));
    }
  };
  /// Sine and cosine of |g| by c.
  LAMELLA_INLINE SineCosine<Real> side_angle(Real c, const Half& side) const {
    using std::abs, std::cbrt;
    const Real x = nonnegative(c - Real(kLeastFront));
    const Real r = multiply_add(x * reciprocal(x + Real(kFrontPlace)), Real(2), Real(-1));
    const Real t = multiply_add(side.column(), Real(2), Real(-1));
    Real value(0);
#pragma GCC unroll 16
    for (int i = kFrontRows - 1; i >= 0; --i) {
      Real row(tables[i * kFrontColumns + kFrontColumns - 1]);
#pragma GCC unroll 16
      for (int j = kFrontColumns - 2; j >= 0; --j)
        row = multiply_add(row, t, Real(tables[i * kFrontColumns + j]));
      value = multiply_add(value, r, row);
    }
    auto angle = sine_cosine_of_half_turns(value * reciprocal_sqrt(x + Real(kFrontScale)));
    const Mask back = c < Real(kLeastFront);
    if (!any(back)) return angle;
    const Real size = abs(c);
    const Real cube = max(side.exponential * Real(1 / kLargestExponential), Real(1e-20));
    const Real behind = patched<kSideRows, kSideColumns>(
        Words(kSidePatch), size * reciprocal(size + Real(4)), cbrt(cube));
    const auto rest = sine_cosine_of_half_turns(behind * reciprocal(size + Real(2)));
    return {select(back, rest.cosine, angle.sine), select(back, rest.sine, angle.cosine)};
  }
  /// A visible normal from two words.
  LAMELLA_INLINE Vec3<Real> normal(Vec3<Real> wi, Real u, Real row_behind,
                                   const Words* words) const {
    using std::abs;
    const Vec3<Real> flat = wi - u * axis;
    const Real s2 = dot(flat, flat), inverse_s = reciprocal_sqrt(max(s2, Real(1e-10)));
    const Real s = s2 * inverse_s;
    const Mask at_pole = s2 < Real(1e-10), behind = u < Real(0);
    const auto along = [&](Real at, Real pole)
                           LAMELLA_INLINE_LAMBDA { return select(at_pole, pole, inverse_s * at); };
    const Vec3<Real> tangent{along(flat.x, across.x), along(flat.y, across.y),
                             along(flat.z, across.z)};
    const Half plane(words[0]), side(words[1]);
    constexpr unsigned kSheet = kNormalRows * kNormalColumns;
    const auto word = [](Mask m, unsigned value) LAMELLA_INLINE_LAMBDA {
      return select(to_word_mask(m), Words(value), Words(0u));
    };
    const Words sheet = first_patch + Words(kSigmaPieces / 4) + word(!behind, 2 * kSheet) +
                        word(plane.upper, kSheet);
    const Real ahead = nonnegative(u) * reciprocal(multiply_add(width * s, Real(2), abs(u)));
    const Real row = select(behind, row_behind, ahead);
    const Real angle = patched<kNormalRows, kNormalColumns>(sheet, row, plane.column());
    // root = 1 / width; d has the scale kappa |u| + root, b the scale root.
    const Real scale =
        select(behind, width * reciprocal(multiply_add(kappa * width, -u, Real(1))), width);
    const auto turned = sine_cosine_of_half_turns(angle * scale);
    // From d to b = d - arcsin(u) where it is d.
    const Real turn_sine = select(behind, -u, Real(0)), turn_cosine = select(behind, s, Real(1));
    const Real cosine = turned.cosine * turn_cosine - turned.sine * turn_sine;
    const Real sine = multiply_add(turned.sine, turn_cosine, turned.cosine * turn_sine);
    const auto beside = side_angle(kappa * cosine, side);
    const Real rho = beside.cosine, y = select(side.upper, beside.sine, -beside.sine);
    const Vec3<Real> binormal = cross(axis, tangent);
    return y * binormal + (rho * cosine) * axis + (rho * sine) * tangent;
  }
};

/// The same, where the flakes are narrow: light that meets their front alone, or their backs alone,
/// needs no tables. As which of the two a lane takes depends on its light alone, a walk is the same
/// whatever walks are beside it.
template <class Real>
struct NarrowVmfOnLanes : VmfOnLanes<Real> {
  using Mask = MaskOf<Real>;
  using Words = WordsOf<Real>;
  using Base = VmfOnLanes<Real>;
  Vec3<Real> aside;     ///< perpendicular to the axis and to `across`
  Real facing, hidden;  ///< u from which on all flakes face the light, -u from which on none does
  TiltSeries<Real> tilt;
  template <class Reader>
  LAMELLA_INLINE explicit NarrowVmfOnLanes(const Reader& n)
      : Base(n),
        aside(cross(this->axis, this->across)),
        facing(n(kFacing)),
        hidden(n(kHidden)),
        tilt{n(kTilt), n(kTilt + 1), n(kTilt + 2)} {}

  LAMELLA_INLINE Real sigma_of(Real u, Real row) const {
    const Real front = nonnegative(u) * this->mean;
    const Mask plain = (u >= facing) | (u <= -hidden);
    if (!any(!plain)) return front;
    return select(plain, front, Base::sigma_of(u, row));
  }
  LAMELLA_INLINE Real sigma(Vec3<Real> w) const {
    const Real u = dot(w, this->axis);
    return sigma_of(u, this->row_from_behind(u));
  }
  LAMELLA_INLINE Real inverse_area(Vec3<Real> w) const {
    return reciprocal(max(sigma(w), Real(1e-30)));
  }
  LAMELLA_INLINE Vec3<Real> normal(Vec3<Real> wi, Real u, Real row_behind,
                                   const Words* words) const {
    const Mask faces = u >= facing;
    const auto narrow = [&]() LAMELLA_INLINE_LAMBDA {
      const Vec3<Real> light{dot(wi, this->across), dot(wi, aside), u};
      const Vec3<Real> m = narrow_normal(tilt, light, words[0], words[1]);
      return m.x * this->across + m.y * aside + m.z * this->axis;
    };
    if (!any(!faces)) return narrow();
    const Vec3<Real> m = Base::normal(wi, u, row_behind, words);
    if (!any(faces)) return m;
    return select(faces, narrow(), m);
  }
};

}  // namespace lamella
