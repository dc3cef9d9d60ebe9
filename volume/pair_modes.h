#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "phase/color.h"
#include "phase/direction.h"
#include "volume/quadrature.h"

namespace lamella {

// A pair of directions seen through h = w_i + w_o: its horizontal part squared at x = 0 and twice
// the product of the sines, so that |h_xy|^2 = gap + 2 product (1 - cos x).
struct Pair {
  double hz, gap, product;
  Pair(double mu_i, double mu_o) : hz(mu_i + mu_o), product(sine(mu_i) * sine(mu_o)) {
    // s_i - s_o without cancellation
    const double sum = sine(mu_i) + sine(mu_o);
    const double difference = sum > 0 ? (mu_o - mu_i) * (mu_o + mu_i) / sum : 0;
    gap = difference * difference;
  }
};

// What the azimuthal quadrature needs of a medium: the kernel by |h_xy|^2 and h_z, and the square
// of the imaginary part, times the product of the sines, of its nearest singularity in x.
template <class F, class G>
struct Profile {
  F value;
  G reach;
  bool peak_at_zero_x = true;
};
template <class F, class G>
Profile(F, G, bool) -> Profile<F, G>;

// Modes of one pair. samples: |h|^2, h_z -> kernel; the first `modes` cosines in x are summed.
template <class P>
void pair_modes(const P& profile, double f0, double mu_i, double mu_o, Eigen::ArrayXd& result,
                double& white) {
  const Pair pair(mu_i, mu_o);
  const int modes = static_cast<int>(result.size());
  const double reach = profile.reach(mu_i, mu_o, pair.gap);
  const double b = std::clamp(std::sqrt(reach / std::max(pair.product, 1e-300)), 1e-8, 2.0);
  const double stretch = std::asinh(kPi / b);
  const int n = 8 * ((28 + static_cast<int>(4 * stretch) + modes + 7) / 8);
  const Quadrature& rule = cached_gauss_legendre(n);
  Eigen::ArrayXd y(n), weight(n);
  for (int k = 0; k < n; ++k) {
    const double u = rule.points[k] * stretch;
    y[k] = b * std::sinh(u);
    weight[k] = rule.weights[k] * stretch * b * std::cosh(u) / kPi;
  }
  const Eigen::ArrayXd x = profile.peak_at_zero_x ? y : Eigen::ArrayXd(kPi - y);
  double white_sum = 0;
  for (int k = 0; k < n; ++k) {
    const double half = std::sin(x[k] / 2);
    const double hxy2 = pair.gap + 4 * pair.product * half * half;
    double value = weight[k] * profile.value(hxy2, pair.hz);
    white_sum += value;
    // cosine of the half angle: |h| / 2
    if (f0 != 1) value *= f0 + (1 - f0) * schlick_weight(std::sqrt(hxy2 + pair.hz * pair.hz) / 2);
    weight[k] = value;
  }
  white = white_sum;
  const Eigen::ArrayXd step = 2 * x.cos();
  Eigen::ArrayXd before = weight * step / 2, now = weight;  // cos(-x), cos(0 x)
  for (int m = 0; m < modes; ++m) {
    result[m] = now.sum();
    const Eigen::ArrayXd next = step * now - before;
    before = now;
    now = next;
  }
}

}  // namespace lamella
