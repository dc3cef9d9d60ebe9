#include "phase/medium/sggx.h"

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <optional>

#include "phase/math/clamped_cosines.h"
#include "phase/medium/flake.h"

namespace lamella {
namespace {

std::optional<SggxMatrix<double>> cholesky(const std::array<double, 6>& s) {
  const auto [xx, yy, zz, xy, xz, yz] = s;
  SggxMatrix<double> a{};
  a.a00 = std::sqrt(xx);
  a.a10 = xy / a.a00;
  a.a20 = xz / a.a00;
  a.a11 = std::sqrt(yy - a.a10 * a.a10);
  a.a21 = (yz - a.a20 * a.a10) / a.a11;
  a.a22 = std::sqrt(zz - a.a20 * a.a20 - a.a21 * a.a21);
  const auto sound = [](double diagonal, double pivot) {  // false for NaN, too
    return diagonal >= 1e-12 && diagonal <= 1e12 && pivot * pivot > 1e-12 * diagonal;
  };
  if (sound(xx, a.a00) && sound(yy, a.a11) && sound(zz, a.a22)) return a;
  return std::nullopt;
}

std::array<double, 6> two_eigenvalues(double along, double across, Direction n) {
  const double d = along - across;
  return {across + d * n.x * n.x, across + d * n.y * n.y, across + d * n.z * n.z,
          d * n.x * n.y,          d * n.x * n.z,          d * n.y * n.z};
}

// The least over the largest eigenvalue of a symmetric matrix with entries as those of S, by the
// cubic's trigonometric solution.
double eigenvalue_ratio(const std::array<double, 6>& s) {
  const auto [xx, yy, zz, xy, xz, yz] = s;
  const double mean = (xx + yy + zz) / 3;
  const double a = xx - mean, b = yy - mean, c = zz - mean;
  const double spread = std::sqrt((a * a + b * b + c * c + 2 * (xy * xy + xz * xz + yz * yz)) / 6);
  if (!(spread > 1e-8 * mean)) return 1;
  const double determinant =
      a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz);
  const double angle =
      std::acos(std::clamp(determinant / (2 * spread * spread * spread), -1.0, 1.0)) / 3;
  const double most = mean + 2 * spread * std::cos(angle),
               least = mean + 2 * spread * std::cos(angle + 2 * kPi / 3);
  return std::clamp(least / most, 0.0, 1.0);
}

// Panels of kPanelNodes Gauss nodes that an integral over half a circle needs whose integrand is
// analytic within `strip` of the real angles: a panel of half-length h has an error of rho^(-2
// nodes), rho = b + sqrt(1 + b^2), b = strip / h, which b = 0.7 makes 1e-9.
constexpr int kPanelNodes = 16, kMostPanels = 24;
int panels_for(double strip) {
  return static_cast<int>(std::ceil(std::min(kPi / 2 * 0.7 / strip, 1e6)));
}

// The nodes of panels of equal size over [from, to]: f(angle, weight) for each.
template <class F>
void at_nodes(double from, double to, int panels, const F& f) {
  using Rule = boost::math::quadrature::gauss<double, kPanelNodes>;
  const double half = (to - from) / (2 * panels);
  for (int k = 0; k < panels; ++k) {
    const double middle = from + (2 * k + 1) * half;
    for (int j = 0; j < kPanelNodes / 2; ++j) {
      const double step = half * Rule::abscissa()[j], weight = half * Rule::weights()[j];
      f(middle - step, weight);
      f(middle + step, weight);
    }
  }
}

}  // namespace

Sggx::Sggx(const std::array<double, 6>& s)
    : a_(cholesky(s).value()),
      inverse_(a_.inverse()),
      mirror_scale_(1 / (4 * kPi * a_.determinant())),
      axial_(axial_form(s)),
      symmetric_about_z_(s[0] == s[1] && s[3] == 0 && s[4] == 0 && s[5] == 0) {}

std::array<double, 6> Sggx::surface_matrix(double alpha, Direction n) {
  return two_eigenvalues(1, alpha * alpha, n);
}

std::array<double, 6> Sggx::fiber_matrix(double alpha, Direction t) {
  return two_eigenvalues(alpha * alpha, 1, t);
}

bool Sggx::is_positive_definite(const std::array<double, 6>& s) { return cholesky(s).has_value(); }

double Sggx::mirror_phase(Direction wi, Direction wo) const {
  return density_of(half_vector(wi, wo)) / (4 * sigma(wi));
}

std::optional<Sggx::Axial> Sggx::axial_form(const std::array<double, 6>& s) {
  const double xx = s[0], yy = s[1], zz = s[2], xy = s[3], xz = s[4], yz = s[5];
  // S - lambda I has rank 1 for the double eigenvalue lambda, which any non-zero product of two
  // off-diagonal entries gives; its columns then lie along the axis.
  constexpr double kRounding = 1e-14;
  const double scale = xx + yy + zz;
  const auto form = [&](Direction n, double across2) -> std::optional<Axial> {
    const double along2 = scale - 2 * across2;
    if (!(along2 > 0 && across2 > 0)) return std::nullopt;
    const auto back = two_eigenvalues(along2, across2, n);
    for (int k = 0; k < 6; ++k)
      if (std::abs(back[k] - s[k]) > kRounding * scale) return std::nullopt;
    return Axial{n, std::sqrt(along2), std::sqrt(across2)};
  };
  if (xy == 0 && xz == 0 && yz == 0) {
    if (auto axial = form({0, 0, 1}, xx)) return axial;
    if (auto axial = form({1, 0, 0}, yy)) return axial;
    return form({0, 1, 0}, zz);
  }
  const auto leaning = [&](double across2) {
    const Direction columns[] = {
        {xx - across2, xy, xz}, {xy, yy - across2, yz}, {xz, yz, zz - across2}};
    const Direction* longest = &columns[0];
    for (const Direction& c : columns)
      if (dot(c, c) > dot(*longest, *longest)) longest = &c;
    return form(normalized(*longest), across2);
  };
  if (xy != 0 && xz != 0 && yz != 0) return leaning(xx - xy * xz / yz);
  // In a coordinate plane, the third axis has the double eigenvalue.
  return leaning(xy != 0 ? zz : xz != 0 ? yy : xx);
}

double Sggx::diffuse_phase(Direction wi, Direction wo) const {
  return axial_ ? diffuse_phase_about_axis(wi, wo) : diffuse_phase_over_lune(wi, wo);
}

double Sggx::diffuse_phase_about_axis(Direction wi, Direction wo) const {
  // With c the cosine of u with the axis, v = along c / |A u| is that of m.
  const ClampedCosines pair(wi, wo, axial_->axis);
  const double along = axial_->along, across = axial_->across, ratio = across / along;
  const auto norm = [&](double c) {
    return std::hypot(across * std::sqrt((1 - c) * (1 + c)), along * c);
  };
  const auto integrand = [&](double c) {
    const double q = norm(c);
    return q * pair.overlap(std::clamp(along * c / q, -1.0, 1.0));
  };
  std::vector<double> breaks{0};
  for (const double v : pair.kinks()) {
    const double c = across * v / std::hypot(along * std::sqrt((1 - v) * (1 + v)), across * v);
    breaks.insert(breaks.end(), {c, -c});
  }
  // |A u| turns where c is near the ratio of the axes (flat flakes), or 1 - c^2 near its inverse
  // square (needles).
  for (const double step : {0.25, 1.0, 4.0, 16.0, 64.0, 256.0}) {
    const double c = ratio < 1 ? step * ratio : 1 - step / (ratio * ratio);
    if (c > 0 && c < 1) breaks.insert(breaks.end(), {c, -c});
  }
  // Opposite directions see nothing in common but rounding, of either sign.
  return std::max(integrate_panels(integrand, -1.0, 1.0, std::move(breaks)), 0.0) /
         (kPi * kPi * sigma(wi));
}

double Sggx::diffuse_phase_over_lune(Direction wi, Direction wo) const {
  using boost::math::quadrature::gauss_kronrod;
  // With u on the sphere: 1 / (pi^2 sigma_i) times the integral of <A^T w_i, u> <A^T w_o, u> / |A
  // u|. In the frame whose pole is the edge of the lune, u = (r cos psi, r sin psi, t), r^2 = 1 -
  // t^2.
  const Direction vi = a_.apply_transposed(wi), vo = a_.apply_transposed(wo);
  const double li = length(vi), lo = length(vo);
  const Direction i = (1 / li) * vi, o = (1 / lo) * vo;
  Direction pole = cross(i, o);
  const double sine = length(pole);
  const double gap = std::atan2(sine, dot(i, o));  // angle between the two poles of the lune
  if (gap >= kPi) return 0;
  pole = sine > 1e-12 ? (1 / sine) * pole : frame_around(i).s;
  const Direction side = cross(pole, i);

  const Direction ai = a_.apply(i), as = a_.apply(side), ap = a_.apply(pole);
  const double ii = dot(ai, ai), ss = dot(as, as), is = dot(ai, as), ip = dot(ai, ap),
               sp = dot(as, ap), pp = dot(ap, ap);
  // u = (cos(theta) cos(psi), cos(theta) sin(psi), sin(theta)); along an arc of one psi, |A u|^2 is
  // a form of cos(theta) and sin(theta).
  const auto arc = [&](double psi) {
    const double c = std::cos(psi), s = std::sin(psi);
    return std::array{c * c * ii + 2 * c * s * is + s * s * ss, 2 * (c * ip + s * sp),
                      c * std::cos(psi - gap)};
  };
  // |A u|^2 = 0 has no solution within this strip of the real angles.
  const double ratio = std::sqrt(eigenvalue_ratio({ii, ss, pp, is, ip, sp}));
  const int panels = panels_for(std::atanh(std::min(ratio, 1 - 1e-9)));
  if (panels <= kMostPanels) {
    constexpr int kMost = kMostPanels * kPanelNodes;
    std::array<double, kMost> cosines2, mixed, sines2, weights;
    int count = 0;
    at_nodes(-kPi / 2, kPi / 2, panels, [&](double theta, double weight) {
      const double c = std::cos(theta), s = std::sin(theta);
      cosines2[count] = c * c;
      mixed[count] = c * s;
      sines2[count] = s * s * pp;
      weights[count++] = weight * c * c * c;
    });
    double sum = 0;
    at_nodes(gap - kPi / 2, kPi / 2, panels, [&](double psi, double weight) {
      const auto [across, between, clamped] = arc(psi);
      double along = 0;
      for (int k = 0; k < count; ++k)
        along += weights[k] / std::sqrt(cosines2[k] * across + mixed[k] * between + sines2[k]);
      sum += weight * clamped * along;
    });
    return lo * sum / (kPi * kPi);
  }
  const auto over_theta = [&](double psi) {
    const auto [across, between, clamped] = arc(psi);
    const auto integrand = [&, across = across, between = between](double theta) {
      const double c = std::cos(theta), s = std::sin(theta);
      return c * c * c / std::sqrt(c * c * across + c * s * between + s * s * pp);
    };
    return clamped * gauss_kronrod<double, 21>::integrate(integrand, -kPi / 2, kPi / 2, 12, 1e-9);
  };
  // The ridge of 1 / |A u| may cross the lune anywhere; halves let the adaptive rule find it.
  double sum = 0;
  const double from = gap - kPi / 2, width = kPi - gap;
  for (const double part : {0.0, 0.25, 0.5, 0.75})
    sum += gauss_kronrod<double, 21>::integrate(over_theta, from + part * width,
                                                from + (part + 0.25) * width, 12, 1e-8);
  return lo * sum / (kPi * kPi);
}

double Sggx::largest_mirror_phase() const {
  const SggxMatrix<double> b = a_.inverse();
  // The norms bound |A u| above and below.
  const auto norm = [](const SggxMatrix<double>& a) {
    return std::sqrt(a.a00 * a.a00 + a.a10 * a.a10 + a.a11 * a.a11 + a.a20 * a.a20 + a.a21 * a.a21 +
                     a.a22 * a.a22);
  };
  return std::pow(norm(a_), 4) / (4 * kPi * a_.determinant()) * norm(b);
}

}  // namespace lamella
