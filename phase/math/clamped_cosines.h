#pragma once

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss.hpp>
#include <vector>

#include "phase/math/direction.h"

namespace lamella {

/// Two clamped cosines <w_i, m> <w_o, m>, integrated over the azimuth of m about an axis: the
/// integrand of Lambertian flakes whose normals are distributed symmetrically about that axis.
class ClampedCosines {
 public:
  ClampedCosines(Direction wi, Direction wo, Direction axis);

  /// Integral over the azimuth in [0, 2 pi) of <w_i, m> <w_o, m>, for m with m.axis = v in [-1, 1].
  [[nodiscard]] double overlap(double v) const;

  /// The cosines v at which overlap is not smooth: where an arc opens, closes, or two of their ends
  /// meet. In pairs +-.
  [[nodiscard]] std::array<double, 3> kinks() const { return {si_, so_, meeting_}; }
  [[nodiscard]] double sine_i() const { return si_; }

 private:
  double ui_, uo_, si_, so_;
  double gap_;      // azimuth between the two, in [0, pi]
  double meeting_;  // |v| of the direction that is perpendicular to both
};

/// Integral of f over [from, to], split at those `breaks` that lie inside: Gauss-Legendre on each
/// panel after t^2 (3 - 2 t), which makes square-root ends smooth. f must be analytic between the
/// breaks, except for square-root ends, and vary by no more than a few factors of e between
/// neighbouring breaks.
template <class F>
[[nodiscard]] double integrate_panels(const F& f, double from, double to,
                                      std::vector<double> breaks) {
  std::erase_if(breaks, [&](double b) { return !(b > from && b < to); });
  breaks.push_back(from);
  breaks.push_back(to);
  std::sort(breaks.begin(), breaks.end());
  double sum = 0;
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    const double start = breaks[i], width = breaks[i + 1] - breaks[i];
    if (!(width > 0)) continue;
    sum += width *
           boost::math::quadrature::gauss<double, 30>::integrate(
               [&](double t) { return 6 * t * (1 - t) * f(start + width * t * t * (3 - 2 * t)); },
               0.0, 1.0);
  }
  return sum;
}

}  // namespace lamella
