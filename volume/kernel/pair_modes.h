#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "phase/math/color.h"
#include "phase/math/direction.h"
#include "volume/quadrature/quadrature.h"

namespace lamella {

/// A pair of directions seen through h = w_i + w_o: its horizontal part squared at x = 0 and twice
/// the product of the sines, so that |h_xy|^2 = gap + 2 product (1 - cos x).
struct Pair {
  double hz, gap, product;
  Pair(double mu_i, double mu_o) : hz(mu_i + mu_o), product(sine(mu_i) * sine(mu_o)) {
    // s_i - s_o without cancellation
    const double sum = sine(mu_i) + sine(mu_o);
    const double difference = sum > 0 ? (mu_o - mu_i) * (mu_o + mu_i) / sum : 0;
    gap = difference * difference;
  }
};

/// The medium as the azimuthal quadrature sees it. value: the kernel by |h_xy|^2 and h_z. reach: by
/// mu_i, mu_o and the gap, the square of the imaginary part of the kernel's nearest singularity in
/// x, times the product of the sines. peak_at_zero_x: whether the singularity is near x = 0; else
/// near pi. is_even: whether the value is the same for -h_z.
template <class F, class G>
struct Profile {
  F value;
  G reach;
  bool peak_at_zero_x = true;
  bool is_even = true;
};
template <class F, class G>
Profile(F, G, bool, bool) -> Profile<F, G>;

/// Points in the azimuth for kernels whose nearest singularity is at distance b from y = 0 in the
/// imaginary direction, and for the cosines of `modes` modes.
struct AzimuthRule {
  Eigen::ArrayXd y, weight;
};

/// Gauss-Legendre in a variable whose density over y in (0, pi) is that of asinh(y / b), for the
/// singularity, plus a uniform one, for the cosines. b is rounded down to a power of sqrt(2), and
/// each rule is made once per thread.
[[nodiscard]] const AzimuthRule& azimuth_rule(double b, int modes);

/// The first result.size() modes of one pair, and the white mode 0.
template <class P>
void pair_modes(const P& profile, double f0, double mu_i, double mu_o, Eigen::ArrayXd& result,
                double& white) {
  const Pair pair(mu_i, mu_o);
  const int modes = static_cast<int>(result.size());
  const double reach = profile.reach(mu_i, mu_o, pair.gap);
  const AzimuthRule& rule = azimuth_rule(std::sqrt(reach / std::max(pair.product, 1e-300)), modes);
  const Eigen::ArrayXd x = profile.peak_at_zero_x ? rule.y : Eigen::ArrayXd(kPi - rule.y);
  const Eigen::ArrayXd hxy2 = pair.gap + 4 * pair.product * (x / 2).sin().square();
  Eigen::ArrayXd now = rule.weight;
  for (Eigen::Index k = 0; k < now.size(); ++k) now[k] *= profile.value(hxy2[k], pair.hz);
  white = now.sum();
  if (f0 != 1)  // the cosine of the half angle is |h| / 2
    for (Eigen::Index k = 0; k < now.size(); ++k)
      now[k] *= f0 + (1 - f0) * schlick_weight(std::sqrt(hxy2[k] + pair.hz * pair.hz) / 2);
  const Eigen::ArrayXd step = 2 * x.cos();
  Eigen::ArrayXd before = now * step / 2, next;  // cos(-x), cos(0 x)
  for (int m = 0; m < modes; ++m) {
    result[m] = now.sum();
    next = step * now - before;
    before.swap(now);
    now.swap(next);
  }
}

}  // namespace lamella
