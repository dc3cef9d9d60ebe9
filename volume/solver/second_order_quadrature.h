#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

// Quadratures of volume/solver/second_order.h over the direction in between.

namespace lamella {

/// Points of the azimuth of w' as distances from that of -w_i and from that of w_o:
/// 4 sin^2(distance / 2).
struct BetweenAzimuths {
  Eigen::ArrayXd near_in, near_out, weight;
};

/// Gauss-Legendre in asinh about both peaks, on a whole circle. b_in, b_out: distance of the
/// nearest singularity of either kernel. separation: azimuth between the peaks, in [0, pi].
[[nodiscard]] BetweenAzimuths between_azimuths(double separation, double b_in, double b_out);

/// Where an integrand breaks. is_root: it may grow like one over the root of the distance.
struct BetweenBreak {
  double at;
  bool is_root = false;
};

/// A cosine between two breaks of the integrand.
struct BetweenCosine {
  double mu;
  double low, high;            ///< the breaks
  double from_low, from_high;  ///< distances, >= 0, without cancellation

  /// mu less b, without cancellation where b is one of the breaks.
  [[nodiscard]] double minus(double b) const {
    return b == low ? from_low : b == high ? -from_high : mu - b;
  }
};

/// Tanh-sinh quadrature between breaks, on ever finer levels until is_enough(level, integral).
/// at(BetweenCosine): the integrand, a number or an array like zero.
template <class Sum, class At, class IsEnough>
void integrate_between(std::vector<BetweenBreak> breaks, const Sum& zero, const At& at,
                       const IsEnough& is_enough) {
  // Points beyond carry less than 1e-12 of an interval.
  constexpr double kReach = 2.9, kRootReach = 3.6;
  constexpr int kFinest = 6;  // steps 1/2 ... 2^-kFinest
  constexpr double kHalfPi = 1.57079632679489661923;
  std::sort(breaks.begin(), breaks.end(),
            [](const BetweenBreak& a, const BetweenBreak& b) { return a.at < b.at; });
  Sum sum = zero;
  for (int level = 1; level <= kFinest; ++level) {
    const double step = std::ldexp(1.0, -level);
    Sum added = zero;
    for (std::size_t k = 0; k + 1 < breaks.size(); ++k) {
      const double low = breaks[k].at, high = breaks[k + 1].at, half = (high - low) / 2;
      if (half < 1e-14) continue;
      const auto last = [&](const BetweenBreak& end) {
        return static_cast<int>((end.is_root ? kRootReach : kReach) / step);
      };
      for (int n = -last(breaks[k]); n <= last(breaks[k + 1]); ++n) {
        if (level > 1 && n % 2 == 0) continue;
        const double t = n * step, s = kHalfPi * std::sinh(t);
        // Distance from the nearer end, without cancellation.
        const double to_end = half * std::exp(-std::abs(s)) / std::cosh(s);
        const double mu = s < 0 ? low + to_end : high - to_end;
        if (mu == 0) continue;
        const double to_other = 2 * half - to_end;
        const double weight = half * kHalfPi * std::cosh(t) / (std::cosh(s) * std::cosh(s));
        added += weight * at(BetweenCosine{mu, low, high, s < 0 ? to_end : to_other,
                                           s < 0 ? to_other : to_end});
      }
    }
    sum = level == 1 ? Sum(added * step) : Sum(sum / 2 + added * step);
    if (is_enough(level, sum)) break;
  }
}

}  // namespace lamella
