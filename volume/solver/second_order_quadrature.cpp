#include "volume/solver/second_order_quadrature.h"

#include <cmath>

#include "phase/math/direction.h"
#include "volume/quadrature/quadrature.h"

namespace lamella {

using Eigen::ArrayXd;
using Eigen::Index;

BetweenAzimuths between_azimuths(double separation, double b_in, double b_out) {
  struct Half {
    double length, b;
    bool from_in;  // measured from the peak of the first event
    double sign;   // of the other peak's place
  };
  const double wide = kPi - separation / 2, narrow = separation / 2;
  // The other peak lies close behind the start of a wide half where the two are close.
  const double wide_in = std::min(b_in, std::hypot(separation, b_out));
  const double wide_out = std::min(b_out, std::hypot(separation, b_in));
  const Half halves[4] = {{wide, wide_in, true, -1},
                          {wide, wide_out, false, -1},
                          {narrow, b_in, true, 1},
                          {narrow, b_out, false, 1}};
  const auto points = [](const Half& half) {
    return half.length == 0 ? 0 : static_cast<int>(18 + 5 * std::asinh(half.length / half.b));
  };
  Index count = 0;
  for (const Half& half : halves) count += points(half);
  BetweenAzimuths result{ArrayXd(count), ArrayXd(count), ArrayXd(count)};
  Index k = 0;
  const auto chord2 = [](double y) {
    const double s = std::sin(y / 2);
    return 4 * s * s;
  };
  for (const Half& half : halves) {
    const int n = points(half);
    if (n == 0) continue;
    const Quadrature& rule = cached_gauss_legendre(n);
    const double stretch = std::asinh(half.length / half.b);
    for (int l = 0; l < n; ++l, ++k) {
      const double e = std::exp(stretch * rule.points[l]);
      const double y = half.b * (e - 1 / e) / 2;
      result.weight[k] = rule.weights[l] * stretch * half.b * (e + 1 / e) / 2;
      const double here = chord2(y), there = chord2(separation - half.sign * y);
      result.near_in[k] = half.from_in ? here : there;
      result.near_out[k] = half.from_in ? there : here;
    }
  }
  return result;
}

}  // namespace lamella
