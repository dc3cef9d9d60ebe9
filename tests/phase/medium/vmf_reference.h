#pragma once

#include <boost/math/quadrature/tanh_sinh.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>

namespace lamella::testing {

/// The projected area of vMF flakes to more digits than a double has: over the cosine v with the
/// mean normal, the azimuth of the clamped cosine in closed form. (The engine integrates in the
/// frame of w, with a Bessel function.)
using Precise = boost::multiprecision::cpp_bin_float_50;

/// log of the integral of D(m) <w, m> dm, u = w.n, 0 < alpha < infinity.
[[nodiscard]] inline Precise reference_log_vmf_sigma(double u_, double alpha) {
  using std::min;
  const Precise pi = boost::math::constants::pi<Precise>();
  const Precise u(u_), kappa = 2 / (Precise(alpha) * alpha);
  const Precise s = sqrt((1 - u) * (1 + u));
  const Precise top = u < 0 ? s : Precise(1);
  // Integral over the azimuth of <w, m>: 2 (u v arc + s r sin(arc)), arc the half width of what
  // faces w.
  const auto ring = [&](const Precise& v) -> Precise {
    const Precise a = u * v, b = s * sqrt((1 - v) * (1 + v));
    if (a >= b) return 2 * pi * a;
    if (a <= -b) return 0;
    const Precise c = -a / b;
    return 2 * (a * acos(c) + b * sqrt((1 - c) * (1 + c)));
  };
  std::vector<Precise> edges{Precise(-1), -s, s, top};
  for (const int reach : {3, 20, 120}) edges.push_back(top - reach / kappa);
  std::erase_if(edges,
                [&](const Precise& e) { return e < -1 || e > top || e < top - 121 / kappa; });
  std::sort(edges.begin(), edges.end());
  boost::math::quadrature::tanh_sinh<Precise> rule(9);
  Precise sum = 0;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const Precise from = edges[i], to = edges[i + 1];
    if (!(to > from)) continue;
    sum +=
        rule.integrate([&](const Precise& v) { return Precise(exp(kappa * (v - top)) * ring(v)); },
                       from, to, Precise("1e-18"));
  }
  // kappa / (2 pi (1 - exp(-2 kappa))) exp(kappa (top - 1)); 1 - top without cancellation
  const Precise below = u < 0 ? u * u / (1 + s) : Precise(0);
  return log(kappa * sum / (2 * pi * (1 - exp(-2 * kappa)))) - kappa * below;
}

}  // namespace lamella::testing
