#pragma once

#include <cmath>

#include "phase/math/real.h"
#include "phase/math/trigonometry.h"
#include "volume/harmonics/circle_task.h"

namespace lamella {

// (1 - exp(-x)) / x for x >= 0 as a fraction, given exp(-x): relative error below 1e-15.
template <class Real>
struct Fraction {
  Real above, below;
};
template <class Real>
LAMELLA_INLINE Fraction<Real> mean_decay_of(Real x, Real decay) {
  const Real series = polynomial(x, 1.0, -1.0 / 2, 1.0 / 6, -1.0 / 24, 1.0 / 120, -1.0 / 720,
                                 1.0 / 5040, -1.0 / 40320, 1.0 / 362880, -1.0 / 3628800,
                                 1.0 / 39916800, -1.0 / 479001600, 1.0 / 6227020800);
  const auto is_small = x < Real(0.5);
  return {select(is_small, series, Real(1) - decay), select(is_small, Real(1), x)};
}

template <class Real>
LAMELLA_INLINE Real mean_decay_of(Real x) {
  using std::exp;
  const Fraction<Real> mean = mean_decay_of(x, exp(-x));
  return mean.above / mean.below;
}

// Integral over s, t > 0, s + t < 1 of exp(-p s - q t): volume/quadrature/depth_integrals.cpp.
// Relative error below 1e-12.
template <class Real>
LAMELLA_INLINE Real over_triangle_of(Real p, Real q) {
  using std::exp;
  constexpr double kSmall = 0.03;
  const Real low = min(p, q), high = max(p, q), apart = high - low, decay = exp(-low);
  const Fraction<Real> of_low = mean_decay_of(low, decay);
  const Fraction<Real> of_rest = mean_decay_of(apart, exp(-apart));
  // of_low - decay of_rest, over high.
  Real value = (of_low.above * of_rest.below - decay * of_rest.above * of_low.below) /
               (of_low.below * of_rest.below * max(high, Real(kSmall)));
  const auto is_small = high < Real(kSmall);
  if (any(is_small)) {
    Real sum(0), h(1), power(1);
    double factorial = 2;
    for (int n = 0; n < 7; ++n) {
      sum = multiply_add(h, Real((n % 2 ? -1 : 1) / factorial), sum);
      power = power * high;
      h = multiply_add(h, low, power);
      factorial *= n + 3;
    }
    value = select(is_small, sum, value);
  }
  return value;
}

// volume/quadrature/depth_integrals.h, on lanes.
template <class Real>
LAMELLA_INLINE Real decays(Real x, double depth) {
  if (std::isinf(depth)) return Real(1) / x;
  return Real(depth) * mean_decay_of(x * Real(depth));
}
template <class Real>
LAMELLA_INLINE Real crosses(Real x, Real y, double depth) {
  using std::abs;
  using std::exp;
  if (std::isinf(depth)) return Real(0);
  return Real(depth) * exp(-min(x, y) * Real(depth)) * mean_decay_of(abs(x - y) * Real(depth));
}
template <class Real>
LAMELLA_INLINE Real decays(Real x, Real y, double depth) {
  if (std::isinf(depth)) return Real(1) / (x * y);
  return Real(depth * depth) * over_triangle_of(x * Real(depth), y * Real(depth));
}
template <class Real>
LAMELLA_INLINE Real crosses(Real x, Real y, Real z, double depth) {
  using std::exp;
  if (std::isinf(depth)) return Real(0);
  const Real least = min(min(x, y), z), most = max(max(x, y), z);
  const Real middle = max(min(x, y), min(max(x, y), z));
  return Real(depth * depth) * exp(-least * Real(depth)) *
         over_triangle_of((middle - least) * Real(depth), (most - least) * Real(depth));
}

template <class Real>
LAMELLA_INLINE Real wave_at(const CircleWave& w, Real cosine, Real sine) {
  const Real twice = multiply_add(Real(2 * w.d), cosine, Real(2 * w.e) * sine);
  return multiply_add(cosine, twice + Real(w.b), multiply_add(Real(w.c), sine, Real(w.a - w.d)));
}

template <class Real>
LAMELLA_INLINE Real limited(Real ratio, const CircleMirror& m) {
  return min(max(ratio, Real(m.least)), Real(m.largest));
}

// D(h) / 4 of both events.
template <class Real>
LAMELLA_INLINE void densities_at(const CircleMirror& m, Real cosine, Real sine,
                                 const Real (&square)[2], Real (&density)[2]) {
  using std::exp;
  using std::sqrt;
  if (m.is_constant) {
    density[0] = density[1] = Real(m.scale);
    return;
  }
  const Real other[2] = {wave_at(m.other[0], cosine, sine), wave_at(m.other[1], cosine, sine)};
  if (m.is_sggx) {
    // One division for both; h^T S^-1 h is at least |h|^2, which rounding leaves above 1e-32.
    const Real first = max(other[0], Real(1e-100)), second = max(other[1], Real(1e-100));
    const Real inverse = Real(1) / (first * second);
    const Real a = limited(square[0] * second * inverse, m);
    const Real b = limited(square[1] * first * inverse, m);
    density[0] = Real(m.scale) * a * a;
    density[1] = Real(m.scale) * b * b;
    return;
  }
  for (const int event : {0, 1}) {
    const Real along = min(other[event] / sqrt(max(square[event], Real(1e-300))), Real(1));
    density[event] = Real(m.scale) * exp(Real(m.kappa) * (along - Real(1)));
  }
}

// The kernels of both events, by channel.
template <class Real, class Take>
LAMELLA_INLINE void kernels_at(const CircleMirror& m, int channels, Real cosine, Real sine,
                               const Take& take) {
  using std::sqrt;
  const Real square[2] = {nonnegative(wave_at(m.square[0], cosine, sine)),
                          nonnegative(wave_at(m.square[1], cosine, sine))};
  Real density[2];
  densities_at(m, cosine, sine, square, density);
  for (const int event : {0, 1}) {
    Real schlick(0);
    if (m.has_schlick) {
      const Real x = nonnegative(Real(1) - Real(0.5) * sqrt(square[event]));
      schlick = x * x * x * x * x;
    }
    for (int c = 0; c < channels; ++c)
      take(event, c,
           density[event] * Real(m.albedo[c]) *
               multiply_add(Real(1 - m.f0[c]), schlick, Real(m.f0[c])));
  }
}

// Lane: how to load and store Real.
template <class Real, class Lane>
LAMELLA_INLINE void circle_sum_of(const CircleTask& t) {
  using std::exp;
  using std::sqrt;
  constexpr int kMaxChannels = 3;
  double* const sums = t.scratch;
  double* const first = sums + kCirclePoints * t.channels;
  double* const second = first + kCirclePoints * t.mirrors * t.channels;
  double* const rates = second + kCirclePoints * t.mirrors * t.channels;
  Real total[kMaxChannels] = {Real(0), Real(0), Real(0)};
  for (int p = 0; p < t.panels * kCirclePoints; p += Lane::kCount) {
    const int panel = p / kCirclePoints, point = p % kCirclePoints;
    const Real half(t.half[panel]);
    const auto [sine_of, cosine_of] =
        sine_cosine_near_zero(half * Lane::load(t.rule->place + point));
    const Real middle_cosine(t.cosine[panel]), middle_sine(t.sine[panel]);
    const Real cosine = middle_cosine * cosine_of - middle_sine * sine_of;
    const Real sine = middle_sine * cosine_of + middle_cosine * sine_of;
    // Points on the horizon itself are there by rounding.
    const Real inverse_mu = Real(1) / max(wave_at(t.mu, cosine, sine), Real(1e-30));
    const Real weight = half * Lane::load(t.rule->weight + point) * inverse_mu;
    for (int k = 0; k < t.mirrors; ++k)
      kernels_at(t.mirror[k], t.channels, cosine, sine, [&](int event, int c, Real value) {
        Lane::store(value, (event ? second : first) + kCirclePoints * (k * t.channels + c));
      });
    for (int k = 0; k < t.areas; ++k) {
      const Real area = t.area[k] ? Lane::load(t.area[k] + p)
                                  : sqrt(nonnegative(wave_at(t.square_of_area[k], cosine, sine)));
      Lane::store(area * inverse_mu, rates + kCirclePoints * k);
    }
    Real carried[kMaxChannels] = {Real(0), Real(0), Real(0)};  // order 1 on its way along w'
    for (int step = 0; step < t.layers; ++step) {
      const CircleLayer& layer = t.layer[t.onward ? step : t.layers - 1 - step];
      const Real a(layer.a), b(layer.b), c = Lane::load(rates + kCirclePoints * layer.area);
      const double depth = layer.depth;
      if (layer.mirror >= 0 && layer.leave > 0) {
        const double* k1 = first + kCirclePoints * layer.mirror * t.channels;
        const double* k2 = second + kCirclePoints * layer.mirror * t.channels;
        if (layer.a > 0 && layer.enter > 0) {
          const Real both =
              t.onward
                  ? (t.reflects ? decays(a + b, b + c, depth) : crosses(a, c, b, depth))
                  : (t.reflects ? decays(a + b, a + c, depth) : crosses(a, b, a + b + c, depth));
          const Real factor = weight * Real(layer.enter * layer.leave) * both;
          for (int x = 0; x < t.channels; ++x)
            total[x] = multiply_add(
                factor, Lane::load(k1 + kCirclePoints * x) * Lane::load(k2 + kCirclePoints * x),
                total[x]);
        }
        // Onward light enters at the near face, light on its way back at the far one.
        if (step > 0) {
          const Real seen = t.onward == t.reflects ? decays(b + c, depth) : crosses(c, b, depth);
          const Real factor = weight * Real(layer.leave) * seen;
          for (int x = 0; x < t.channels; ++x)
            total[x] =
                multiply_add(factor, carried[x] * Lane::load(k2 + kCirclePoints * x), total[x]);
        }
      }
      if (step + 1 == t.layers) break;
      const Real pass = std::isinf(depth) ? Real(0) : exp(-c * Real(depth));
      for (int x = 0; x < t.channels; ++x) carried[x] = pass * carried[x];
      if (layer.mirror >= 0 && layer.a > 0 && layer.enter > 0) {
        const double* k1 = first + kCirclePoints * layer.mirror * t.channels;
        const Real sent =
            Real(layer.enter) * (t.onward ? crosses(a, c, depth) : decays(a + c, depth));
        for (int x = 0; x < t.channels; ++x)
          carried[x] = multiply_add(sent, Lane::load(k1 + kCirclePoints * x), carried[x]);
      }
    }
  }
  for (int x = 0; x < t.channels; ++x) {
    Lane::store(total[x], sums);
    t.sum[x] = 0;
    for (int k = 0; k < Lane::kCount; ++k) t.sum[x] += sums[k];
  }
}

}  // namespace lamella
