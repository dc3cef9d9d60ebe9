#include "volume/kernel/lambert_flake_kernel.h"

#include <algorithm>
#include <cmath>
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

// Points and weights D(v) dv, graded so that the half-integer powers of c_m at v = +-s, where an
// arc of positive cosine opens or closes, and D itself are smooth on every panel.
template <class Ndf>
Quadrature normals(const Ndf& ndf, const VectorXd& out, const VectorXd& in) {
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
  constexpr int kWide = 24, kNarrow = 6;
  std::vector<double> points, weights;
  for (std::size_t p = 0; p + 1 < breaks.size(); ++p) {
    const double length = breaks[p + 1] - breaks[p];
    const Quadrature& rule = cached_gauss_legendre(length > 0.05   ? kWide
                                                   : length > 1e-3 ? 10
                                                                   : kNarrow);
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

// The modes of the clamped cosines <w, m> for signed cosines mu (rows) and v (columns), times the
// sign that the azimuth x gives to one of two: c_m = 1/(2 pi) integral of max(0, a + b cos phi)
// cos(m phi), a = mu v, b = sin sin, positive for |phi| < psi.
std::vector<MatrixXd> clamped_modes(const VectorXd& mu, const VectorXd& v, int modes) {
  std::vector<MatrixXd> c(modes, MatrixXd(mu.size(), v.size()));
  std::vector<double> sines(modes + 2);
  for (Eigen::Index j = 0; j < v.size(); ++j)
    for (Eigen::Index i = 0; i < mu.size(); ++i) {
      const double a = mu[i] * v[j], b = sine(mu[i]) * sine(v[j]);
      const double psi = a >= b ? kPi : a <= -b ? 0 : std::acos(-a / b);
      if (psi == 0 || psi == kPi) {
        for (int m = 0; m < modes; ++m) c[m](i, j) = psi == 0 || m > 1 ? 0 : m == 0 ? a : b / 2;
        continue;
      }
      const double s1 = std::sin(psi), c1 = 2 * std::cos(psi);
      sines[0] = 0;
      sines[1] = s1;
      for (int m = 2; m < modes + 2; ++m) sines[m] = c1 * sines[m - 1] - sines[m - 2];
      for (int m = 0; m < modes; ++m) {
        if (m == 0)
          c[m](i, j) = (a * psi + b * s1) / kPi;
        else if (m == 1)
          c[m](i, j) = (a * s1 + b / 2 * (psi + sines[2] / 2)) / kPi;
        else
          c[m](i, j) =
              (a * sines[m] / m + b / 2 * (sines[m - 1] / (m - 1) + sines[m + 1] / (m + 1))) / kPi;
      }
    }
  return c;
}

template <class Ndf>
KernelModes factorised(const Ndf& ndf, const VectorXd& out, const VectorXd& in, int modes) {
  Quadrature v;
  if (ndf.is_delta()) {
    v.points = VectorXd::Constant(1, 1);
    v.weights = VectorXd::Constant(1, 1 / (2 * kPi));
    if constexpr (std::is_same_v<Ndf, Vmf>) v.points[0] = ndf.axis().z;
  } else {
    v = normals(ndf, out, in);
  }
  const auto both_signs = [](const VectorXd& mu) {
    VectorXd both(2 * mu.size());
    both << mu, -mu;
    return both;
  };
  const std::vector<MatrixXd> co = clamped_modes(both_signs(out), v.points, modes);
  const std::vector<MatrixXd> ci = clamped_modes(both_signs(in), v.points, modes);
  KernelModes kernel;
  const Eigen::Index no = out.size(), ni = in.size();
  for (int m = 0; m < modes; ++m) {
    const double sign = m % 2 ? -2 : 2;
    const MatrixXd all = co[m] * (sign * v.weights).asDiagonal() * ci[m].transpose();
    kernel.modes.push_back({all.topLeftCorner(no, ni), all.bottomLeftCorner(no, ni),
                            all.bottomRightCorner(no, ni), all.topRightCorner(no, ni)});
  }
  kernel.white = kernel.modes[0];
  return kernel;
}

}  // namespace

KernelModes lambert_flake_modes(const Sggx& ndf, const VectorXd& out, const VectorXd& in,
                                int modes) {
  return factorised(ndf, out, in, modes);
}

KernelModes lambert_flake_modes(const Vmf& ndf, const VectorXd& out, const VectorXd& in,
                                int modes) {
  return factorised(ndf, out, in, modes);
}

}  // namespace lamella
