#include "volume/azimuthal_kernel.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "volume/quadrature.h"

namespace lamella {
namespace {

using Eigen::ArrayXd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double sine(double mu) { return std::sqrt((1 - mu) * (1 + mu)); }

const Quadrature& cached_rule(int n) {
  thread_local std::map<int, Quadrature> rules;
  auto it = rules.find(n);
  if (it == rules.end()) it = rules.emplace(n, gauss_legendre(n)).first;
  return it->second;
}

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
void pair_modes(const P& profile, double f0, double mu_i, double mu_o, ArrayXd& result,
                double& white) {
  const Pair pair(mu_i, mu_o);
  const int modes = static_cast<int>(result.size());
  const double reach = profile.reach(mu_i, mu_o, pair.gap);
  const double b = std::clamp(std::sqrt(reach / std::max(pair.product, 1e-300)), 1e-8, 2.0);
  const double stretch = std::asinh(kPi / b);
  const int n = 8 * ((28 + static_cast<int>(4 * stretch) + modes + 7) / 8);
  const Quadrature& rule = cached_rule(n);
  ArrayXd y(n), weight(n);
  for (int k = 0; k < n; ++k) {
    const double u = rule.points[k] * stretch;
    y[k] = b * std::sinh(u);
    weight[k] = rule.weights[k] * stretch * b * std::cosh(u) / kPi;
  }
  const ArrayXd x = profile.peak_at_zero_x ? y : ArrayXd(kPi - y);
  double white_sum = 0;
  for (int k = 0; k < n; ++k) {
    const double half = std::sin(x[k] / 2);
    const double hxy2 = pair.gap + 4 * pair.product * half * half;
    double value = weight[k] * profile.value(hxy2, pair.hz);
    white_sum += value;
    // cosine of the half angle: |h| / 2
    if (f0 != 1)
      value *= f0 + (1 - f0) * schlick_weight(std::sqrt(hxy2 + pair.hz * pair.hz) / 2);
    weight[k] = value;
  }
  white = white_sum;
  const ArrayXd step = 2 * x.cos();
  ArrayXd before = weight * step / 2, now = weight;  // cos(-x), cos(0 x)
  for (int m = 0; m < modes; ++m) {
    result[m] = now.sum();
    const ArrayXd next = step * now - before;
    before = now;
    now = next;
  }
}

constexpr int kSignIn[4] = {1, 1, -1, -1};
constexpr int kSignOut[4] = {1, -1, -1, 1};

template <class P>
KernelModes sampled(const P& profile, double f0, const VectorXd& out, const VectorXd& in, int modes,
                    bool two_sided) {
  KernelModes kernel;
  Parts empty;
  for (MatrixXd& part : empty) part.resize(out.size(), in.size());
  kernel.modes.assign(modes, empty);
  kernel.white = empty;
  ArrayXd values(modes);
  for (int part = 0; part < (two_sided ? 2 : 4); ++part)
    for (Eigen::Index j = 0; j < in.size(); ++j)
      for (Eigen::Index i = 0; i < out.size(); ++i) {
        pair_modes(profile, f0, kSignIn[part] * in[j], kSignOut[part] * out[i], values,
                   kernel.white[part](i, j));
        for (int m = 0; m < modes; ++m) kernel.modes[m][part](i, j) = values[m];
      }
  if (two_sided)
    for (int part = 0; part < 2; ++part) {
      for (Parts& mode : kernel.modes) mode[part + 2] = mode[part];
      kernel.white[part + 2] = kernel.white[part];
    }
  return kernel;
}

// D(v) of a vertical distribution, and the points that its quadrature in v must not straddle.
double normal_density_at(const Sggx& ndf, double v) {
  return ndf.density_of({sine(v), 0, v});
}
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
  breaks.erase(std::unique(breaks.begin(), breaks.end(),
                           [](double a, double b) { return b - a < 1e-15; }),
               breaks.end());
  constexpr int kWide = 16, kNarrow = 6;
  std::vector<double> points, weights;
  for (std::size_t p = 0; p + 1 < breaks.size(); ++p) {
    const double length = breaks[p + 1] - breaks[p];
    const Quadrature& rule = cached_rule(length > 0.05 ? kWide : length > 1e-3 ? 10 : kNarrow);
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
        for (int m = 0; m < modes; ++m)
          c[m](i, j) = psi == 0 || m > 1 ? 0 : m == 0 ? a : b / 2;
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
          c[m](i, j) = (a * sines[m] / m +
                        b / 2 * (sines[m - 1] / (m - 1) + sines[m + 1] / (m + 1))) /
                       kPi;
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
    const MatrixXd all =
        co[m] * (sign * v.weights).asDiagonal() * ci[m].transpose();
    kernel.modes.push_back({all.topLeftCorner(no, ni), all.bottomLeftCorner(no, ni),
                            all.bottomRightCorner(no, ni), all.topRightCorner(no, ni)});
  }
  kernel.white = kernel.modes[0];
  return kernel;
}

template <class Ndf>
KernelModes mirror(const MirrorFlakes<Ndf>& flakes, double ratio, double f0, const VectorXd& out,
                   const VectorXd& in, int modes, bool two_sided) {
  const double shrink = std::min(1.0, ratio * ratio);
  return sampled(
      Profile{[&](double hxy2, double hz) {
                return flakes.ndf.density_of({std::sqrt(hxy2), 0, hz}) / 4;
              },
              [&](double mu_i, double mu_o, double gap) {
                return gap + shrink * (mu_i + mu_o) * (mu_i + mu_o);
              },
              true},
      f0, out, in, modes, two_sided);
}

}  // namespace

KernelModes kernel_modes(const Medium& medium, double f0, const VectorXd& out, const VectorXd& in,
                         int modes) {
  const auto opposite = [](double mu_i, double mu_o, double gap) {
    return gap + (mu_i + mu_o) * (mu_i + mu_o);
  };
  struct Visitor {
    double f0;
    const VectorXd &out, &in;
    int modes;
    const decltype(opposite)& reach;

    KernelModes operator()(const MirrorFlakes<Sggx>& m) const {
      const double ratio = m.ndf.sigma({1, 0, 0}) / m.ndf.sigma({0, 0, 1});
      return mirror(m, ratio, f0, out, in, modes, true);
    }
    KernelModes operator()(const MirrorFlakes<Vmf>& m) const {
      return mirror(m, m.ndf.alpha(), f0, out, in, modes, false);
    }
    KernelModes operator()(const LambertFlakes<Sggx>& m) const {
      return factorised(m.ndf, out, in, modes);
    }
    KernelModes operator()(const LambertFlakes<Vmf>& m) const {
      return factorised(m.ndf, out, in, modes);
    }
    KernelModes operator()(const LambertSphere&) const {
      return sampled(Profile{[](double hxy2, double hz) {
                               return lambert_sphere_phase(
                                   std::max(-1.0, 1 - (hxy2 + hz * hz) / 2));
                             },
                             reach, true},
                     1, out, in, modes, true);
    }
    KernelModes operator()(const HenyeyGreenstein& m) const {
      const double g = std::abs(m.g);
      const double width = g > 0 ? (1 - g) * (1 - g) / g : 1e3;
      const bool forward = m.g >= 0;
      return sampled(Profile{[&](double hxy2, double hz) {
                               return henyey_greenstein_phase(m.g, 1 - (hxy2 + hz * hz) / 2);
                             },
                             [&](double mu_i, double mu_o, double gap) {
                               const double dz = forward ? mu_i + mu_o : mu_i - mu_o;
                               return width + gap + dz * dz;
                             },
                             forward},
                     1, out, in, modes, true);
    }
  };
  return std::visit(Visitor{f0, out, in, modes, opposite}, medium);
}

bool is_same_medium(const Medium& a, const Medium& b) {
  if (a.index() != b.index()) return false;
  const auto same_ndf = [](const auto& m, const auto& n) {
    using Ndf = std::decay_t<decltype(m)>;
    if constexpr (std::is_same_v<Ndf, Sggx>) {
      const auto &p = m.matrix(), &q = n.matrix();
      return p.a00 == q.a00 && p.a10 == q.a10 && p.a11 == q.a11 && p.a20 == q.a20 &&
             p.a21 == q.a21 && p.a22 == q.a22;
    } else {
      return m.alpha() == n.alpha() && m.axis() == n.axis();
    }
  };
  return std::visit(
      [&](const auto& m) {
        using M = std::decay_t<decltype(m)>;
        const M& n = std::get<M>(b);
        if constexpr (std::is_same_v<M, HenyeyGreenstein>)
          return m.g == n.g;
        else if constexpr (std::is_same_v<M, LambertSphere>)
          return true;
        else
          return same_ndf(m.ndf, n.ndf);
      },
      a);
}

bool is_two_sided(const Medium& medium) {
  return !std::holds_alternative<MirrorFlakes<Vmf>>(medium) &&
         !std::holds_alternative<LambertFlakes<Vmf>>(medium);
}

}  // namespace lamella
