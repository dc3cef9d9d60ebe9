#include "volume/kernel/lambert_flake_kernel.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "volume/quadrature/quadrature.h"

namespace lamella {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// D(v) of a vertical distribution, and the points that its quadrature in v must not straddle.
double normal_density_at(const Sggx& ndf, double v) { return ndf.density_of({sine(v), 0, v}); }
double normal_density_at(const Vmf& ndf, double v) { return ndf.density_of({sine(v), 0, v}); }

void graded(std::vector<double>& breaks, double centre, double width) {
  for (double step = width; step < 2; step *= 2) {
    breaks.push_back(centre - step);
    breaks.push_back(centre + step);
  }
}
void add_breaks(const Sggx& ndf, std::vector<double>& breaks) {
  const double ratio = ndf.sigma({1, 0, 0}) / ndf.sigma({0, 0, 1});
  // D is a function of v^2 with poles where (1 - v^2) / ratio^2 + v^2 = 0.
  if (ratio < 1) {
    graded(breaks, 1, ratio * ratio / 2);
    graded(breaks, -1, ratio * ratio / 2);
  } else {
    breaks.push_back(0);
    graded(breaks, 0, 1 / ratio);
  }
}
void add_breaks(const Vmf& ndf, std::vector<double>& breaks) {
  const double kappa = vmf_concentration(ndf.alpha());
  graded(breaks, ndf.axis().z, std::min(1.0, 4 / std::max(kappa, 1e-9)));
}

// Points of panels in v: wider than 0.05, than 0.001, and less.
struct PanelPoints {
  int wide, middle, narrow;
};
constexpr PanelPoints kPointsOfNodes{24, 10, 6}, kPointsOfPairs{16, 10, 6};

// Points and weights D(v) dv, graded so that the half-integer powers of c_m at v = +-s, where an
// arc of positive cosine opens or closes, and D itself are smooth on every panel.
template <class Ndf>
Quadrature normals(const Ndf& ndf, const VectorXd& out, const VectorXd& in,
                   const PanelPoints& panel_points) {
  std::vector<double> breaks{-1, 1};
  for (const VectorXd* set : {&out, &in})
    for (const double mu : *set)
      for (const double sign : {-1.0, 1.0}) breaks.push_back(sign * sine(mu));
  add_breaks(ndf, breaks);
  std::erase_if(breaks, [](double v) { return std::abs(v) > 1; });
  std::sort(breaks.begin(), breaks.end());
  breaks.erase(
      std::unique(breaks.begin(), breaks.end(), [](double a, double b) { return b - a < 1e-15; }),
      breaks.end());
  std::vector<double> points, weights;
  for (std::size_t p = 0; p + 1 < breaks.size(); ++p) {
    const double length = breaks[p + 1] - breaks[p];
    const Quadrature& rule = cached_gauss_legendre(length > 0.05   ? panel_points.wide
                                                   : length > 1e-3 ? panel_points.middle
                                                                   : panel_points.narrow);
    for (Eigen::Index k = 0; k < rule.points.size(); ++k) {
      const double angle = kPi * rule.points[k];
      const double half = std::sin(angle / 2);
      const double v = breaks[p] + length * half * half;
      const double weight = rule.weights[k] * length * kPi / 2 * std::sin(angle);
      const double density = normal_density_at(ndf, v) * weight;
      if (density < 1e-40) continue;
      points.push_back(v);
      weights.push_back(density);
    }
  }
  Quadrature result;
  result.points = Eigen::Map<VectorXd>(points.data(), static_cast<Eigen::Index>(points.size()));
  result.weights = Eigen::Map<VectorXd>(weights.data(), static_cast<Eigen::Index>(weights.size()));
  return result;
}

// The modes of the clamped cosine <w, m> for a signed cosine mu and v, times the sign that the
// azimuth x gives to one of two: c_m = 1/(2 pi) integral of max(0, a + b cos phi) cos(m phi), a =
// mu v, b = sin sin, positive for |phi| < psi. `sines`: room for two more than c has. Returns how
// many of them are not 0.
std::size_t clamped_modes(double mu, double v, std::span<double> sines, std::span<double> c) {
  const double a = mu * v, b = sine(mu) * sine(v);
  const double psi = a >= b ? kPi : a <= -b ? 0 : std::acos(-a / b);
  const std::size_t modes = c.size();
  if (psi == 0 || psi == kPi) {
    for (std::size_t m = 0; m < modes; ++m) c[m] = psi == 0 || m > 1 ? 0 : m == 0 ? a : b / 2;
    return psi == 0 ? 0 : std::min<std::size_t>(2, modes);
  }
  const double s1 = std::sin(psi), c1 = 2 * std::cos(psi);
  sines[0] = 0;
  sines[1] = s1;
  for (std::size_t m = 2; m < modes + 2; ++m) sines[m] = c1 * sines[m - 1] - sines[m - 2];
  for (std::size_t k = 0; k < modes; ++k) {
    const auto m = static_cast<double>(k);
    if (k == 0)
      c[k] = (a * psi + b * s1) / kPi;
    else if (k == 1)
      c[k] = (a * s1 + b / 2 * (psi + sines[2] / 2)) / kPi;
    else
      c[k] = (a * sines[k] / m + b / 2 * (sines[k - 1] / (m - 1) + sines[k + 1] / (m + 1))) / kPi;
  }
  return modes;
}

// The same for cosines mu (rows) and v (columns).
std::vector<MatrixXd> clamped_modes(const VectorXd& mu, const VectorXd& v, int modes) {
  std::vector<MatrixXd> c(modes, MatrixXd(mu.size(), v.size()));
  std::vector<double> sines(modes + 2), one(modes);
  for (Eigen::Index j = 0; j < v.size(); ++j)
    for (Eigen::Index i = 0; i < mu.size(); ++i) {
      clamped_modes(mu[i], v[j], sines, one);
      for (int m = 0; m < modes; ++m) c[m](i, j) = one[m];
    }
  return c;
}

template <class Ndf>
KernelModes factorised(const Ndf& ndf, const VectorXd& out, const VectorXd& in, int modes,
                       const MatrixProduct& product) {
  // Flakes that are the same from both sides treat light from below as from above.
  constexpr bool kTwoSided = std::is_same_v<Ndf, Sggx>;
  Quadrature v;
  if (ndf.is_delta()) {
    v.points = VectorXd::Constant(1, 1);
    v.weights = VectorXd::Constant(1, 1 / (2 * kPi));
    if constexpr (std::is_same_v<Ndf, Vmf>) v.points[0] = ndf.axis().z;
  } else {
    v = normals(ndf, out, in, kPointsOfNodes);
  }
  const auto both_signs = [](const VectorXd& mu) {
    VectorXd both(2 * mu.size());
    both << mu, -mu;
    return both;
  };
  const std::vector<MatrixXd> co = clamped_modes(both_signs(out), v.points, modes);
  const std::vector<MatrixXd> ci = clamped_modes(kTwoSided ? in : both_signs(in), v.points, modes);
  KernelModes kernel;
  const Eigen::Index no = out.size(), ni = in.size();
  for (int m = 0; m < modes; ++m) {
    const double sign = m % 2 ? -2 : 2;
    const MatrixXd all =
        product(co[m], ((sign * v.weights).asDiagonal() * ci[m].transpose()).eval());
    const Parts& last = kernel.modes.emplace_back(
        Parts{all.topLeftCorner(no, ni), all.bottomLeftCorner(no, ni), {}, {}});
    kernel.modes.back()[kBelowToDown] =
        kTwoSided ? last[kAboveToUp] : MatrixXd(all.bottomRightCorner(no, ni));
    kernel.modes.back()[kBelowToUp] =
        kTwoSided ? last[kAboveToDown] : MatrixXd(all.topRightCorner(no, ni));
  }
  kernel.white = kernel.modes[0];
  return kernel;
}

template <class Ndf>
VectorXd of_pair(const Ndf& ndf, double mu_o, double mu_i, int modes) {
  const Quadrature v = normals(ndf, VectorXd::Constant(1, std::abs(mu_o)),
                               VectorXd::Constant(1, std::abs(mu_i)), kPointsOfPairs);
  const auto count = static_cast<std::size_t>(modes);
  std::vector<double> sines(count + 2), co(count), ci(count);
  VectorXd kernel = VectorXd::Zero(modes);
  for (Eigen::Index k = 0; k < v.points.size(); ++k) {
    const std::size_t some = clamped_modes(mu_o, v.points[k], sines, co);
    if (some == 0) continue;
    const std::size_t others = clamped_modes(mu_i, v.points[k], sines, ci);
    for (std::size_t m = 0; m < std::min(some, others); ++m)
      kernel[static_cast<Eigen::Index>(m)] += v.weights[k] * co[m] * ci[m];
  }
  for (int m = 0; m < modes; ++m) kernel[m] *= m % 2 ? -2 : 2;
  return kernel;
}

}  // namespace

VectorXd lambert_flake_modes(const Sggx& ndf, double mu_o, double mu_i, int modes) {
  return of_pair(ndf, mu_o, mu_i, modes);
}

VectorXd lambert_flake_modes(const Vmf& ndf, double mu_o, double mu_i, int modes) {
  return of_pair(ndf, mu_o, mu_i, modes);
}

KernelModes lambert_flake_modes(const Sggx& ndf, const VectorXd& out, const VectorXd& in, int modes,
                                const MatrixProduct& product) {
  return factorised(ndf, out, in, modes, product);
}

KernelModes lambert_flake_modes(const Vmf& ndf, const VectorXd& out, const VectorXd& in, int modes,
                                const MatrixProduct& product) {
  return factorised(ndf, out, in, modes, product);
}

}  // namespace lamella
