#pragma once

#include <algorithm>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <span>
#include <vector>

#include "phase/direction.h"

namespace lamella {

/// Two clamped cosines <w_i, m> <w_o, m>, integrated over the azimuth of m about an axis: what a
/// distribution of Lambertian normals that is symmetric about that axis needs.
class ClampedCosines {
 public:
  ClampedCosines(Direction wi, Direction wo, Direction axis);

  /// Integral over the azimuth in [0, 2 pi) of <w_i, m> <w_o, m>, for m with m.axis = v in [-1, 1].
  [[nodiscard]] double overlap(double v) const;

  [[nodiscard]] double sine_i() const { return si_; }
  [[nodiscard]] double sine_o() const { return so_; }

 private:
  double ui_, uo_, si_, so_;
  double gap_;  // azimuth between the two, in [0, pi]
};

/// Adaptive Gauss-Kronrod quadrature of f over [from, to], split at those `breaks` that lie inside.
template <class F>
[[nodiscard]] double integrate_panels(const F& f, double from, double to,
                                      std::vector<double> breaks, double tolerance = 1e-10) {
  using boost::math::quadrature::gauss_kronrod;
  std::erase_if(breaks, [&](double b) { return !(b > from && b < to); });
  breaks.push_back(from);
  breaks.push_back(to);
  std::sort(breaks.begin(), breaks.end());
  double sum = 0;
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i)
    if (breaks[i + 1] > breaks[i])
      sum += gauss_kronrod<double, 21>::integrate(f, breaks[i], breaks[i + 1], 10, tolerance);
  return sum;
}

}  // namespace lamella
