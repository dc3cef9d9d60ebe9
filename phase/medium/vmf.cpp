#include "phase/medium/vmf.h"

#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/special_functions/bessel.hpp>
#include <limits>

#include "phase/math/clamped_cosines.h"
#include "phase/medium/flake.h"
#include "phase/medium/vmf_mixture.h"

namespace lamella {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Below this log sigma no light ever meets a flake, and D / sigma is rounding: p is taken as 0.
constexpr double kNothing = -1e10;
// A projected area below which ratios are taken in log space.
constexpr double kUnderflow = 1e-20;
// A projected area below which light meets no flake: it is taken as 0.
constexpr double kNoFlake = 1e-30;
// A projected area from which on normals are tried one after the other.
constexpr double kOftenSeen = 0.125;
// Flakes narrower than this show their likeliest normal only; a quadrature would meet rounding.
constexpr double kNarrow = 1e-5;

// exp(-x) I0(x), relative error below 1e-15.
double scaled_bessel_i0(double x) {
  if (x < 30) return boost::math::cyl_bessel_i(0, x) * std::exp(-x);
  double term = 1, sum = 1;
  for (int k = 1; k <= 24; ++k) {
    term *= (2 * k - 1.0) * (2 * k - 1.0) / (8 * x * k);
    sum += term;
    if (term < 1e-17) break;
  }
  return sum / std::sqrt(2 * kPi * x);
}

// kappa / (1 - exp(-2 kappa)), 1/2 at kappa = 0.
double normalisation(double kappa) {
  return kappa < 1e-9 ? 0.5 * (1 + kappa) : kappa / -std::expm1(-2 * kappa);
}

}  // namespace

double vmf_concentration(double alpha) { return 2 / (alpha * alpha); }

double vmf_alpha(double roughness) { return -std::log1p(-std::sqrt(roughness)); }

double vmf_density(double kappa, double cosine) {
  return normalisation(kappa) * std::exp(kappa * (cosine - 1)) / (2 * kPi);
}

double vmf_mean_cosine(double kappa) {
  if (kappa == kInfinity) return 1;
  if (kappa < 0.05) {
    const double k2 = kappa * kappa;
    return kappa * (1.0 / 3 + k2 * (-1.0 / 45 + k2 * (2.0 / 945 - k2 / 4725)));
  }
  return 1 / std::tanh(kappa) - 1 / kappa;
}

double log_vmf_sigma(double u, double alpha) {
  const double kappa = vmf_concentration(alpha);
  if (kappa == kInfinity) return u > 0 ? std::log(u) : -kInfinity;
  if (kappa == 0) return std::log(0.25);
  // All terms are positive: no cancellation.
  if (u > 0) return std::log(std::exp(log_vmf_sigma(-u, alpha)) + u * vmf_mean_cosine(kappa));
  // In the frame of w, e the elevation of m above its horizon, a the depth of the mean normal below
  // it: normalisation times the integral over [0, pi/2] of
  // sin(e) cos(e) exp(kappa (cos(e + a) - 1)) exp(-x) I0(x), x = kappa cos(a) cos(e).
  const double a = std::asin(-u);
  const double s = std::sqrt((1 - u) * (1 + u));
  // kappa (cos(e + a) - cos(a)), exact where it is small
  const auto exponent = [&](double e) {
    return -2 * kappa * std::sin(e / 2 + a) * std::sin(e / 2);
  };
  const auto integrand = [&](double e) {
    return std::sin(e) * std::cos(e) * std::exp(exponent(e)) *
           scaled_bessel_i0(kappa * s * std::cos(e));
  };
  // Where the integrand ends: at most where 0.19 kappa (e^2 / 2 + a e), a bound of the exponent,
  // reaches 45; then by bisection.
  const double reach = 45 / (0.19 * kappa);
  double end = std::min(kPi / 2, 2 * reach / (a + std::sqrt(a * a + 2 * reach)));
  for (double inside = 0; exponent(end) < -45 && end - inside > 1e-3 * end;) {
    const double middle = (inside + end) / 2;
    (exponent(middle) > -45 ? inside : end) = middle;
  }
  double sum = 0;
  constexpr int kPanels = 6;
  for (int i = 0; i < kPanels; ++i)
    sum += boost::math::quadrature::gauss<double, 30>::integrate(integrand, end * i / kPanels,
                                                                 end * (i + 1) / kPanels);
  return std::log(normalisation(kappa)) + std::log(sum) - kappa * u * u / (1 + s);
}

double vmf_sigma(double u, double alpha) {
  if (alpha == 0) return std::max(u, 0.0);
  return std::exp(log_vmf_sigma(u, alpha));
}

// An alpha so small that kappa overflows is a delta.
Vmf::Vmf(double alpha, Direction axis)
    : alpha_(vmf_concentration(alpha) == kInfinity ? 0 : alpha),
      kappa_(vmf_concentration(alpha)),
      axis_(axis),
      mean_cosine_(vmf_mean_cosine(kappa_)) {
  if (is_delta()) {
    front_ = 1;
    return;
  }
  table_end_ = std::min(1.0, 10 * alpha);
  table_.resize(kPieces);
  for (int piece = 0; piece < kPieces; ++piece) {
    // Chebyshev interpolation on the piece, turned into powers of t in [-1, 1].
    std::array<double, kDegree + 1> values{}, chebyshev{};
    for (int j = 0; j <= kDegree; ++j) {
      const double t = std::cos(kPi * (j + 0.5) / (kDegree + 1));
      values[j] = vmf_sigma(-table_end_ * (piece + (t + 1) / 2) / kPieces, alpha);
    }
    for (int k = 0; k <= kDegree; ++k) {
      for (int j = 0; j <= kDegree; ++j)
        chebyshev[k] += values[j] * std::cos(kPi * k * (j + 0.5) / (kDegree + 1));
      chebyshev[k] *= (k == 0 ? 1.0 : 2.0) / (kDegree + 1);
    }
    std::array<double, kDegree + 1> older{}, old{}, &powers = table_[piece];
    older[0] = 1;
    old[1] = 1;
    powers = {};
    powers[0] = chebyshev[0];
    powers[1] = chebyshev[1];
    for (int k = 2; k <= kDegree; ++k) {
      std::array<double, kDegree + 1> next{};
      for (int j = 0; j <= kDegree; ++j) next[j] = (j > 0 ? 2 * old[j - 1] : 0) - older[j];
      for (int j = 0; j <= kDegree; ++j) powers[j] += chebyshev[k] * next[j];
      older = old;
      old = next;
    }
  }
  front_ = sigma_of_cosine(1);
  back_ = sigma_of_cosine(-1);
  side_ = sigma_of_cosine(0);
}

double Vmf::back_sigma(double x) const {
  if (x > table_end_) return 0;
  const double scaled = x / table_end_ * kPieces;
  const int piece = std::min(static_cast<int>(scaled), kPieces - 1);
  const double t = 2 * (scaled - piece) - 1;
  const auto& c = table_[piece];
  // Estrin's scheme: Horner's is one chain of dependent operations.
  static_assert(kDegree == 8);
  const double t2 = t * t, t4 = t2 * t2;
  const double low = (c[0] + c[1] * t) + (c[2] + c[3] * t) * t2;
  const double high = (c[4] + c[5] * t) + (c[6] + c[7] * t) * t2;
  const double value = low + (high + c[8] * t4) * t4;
  return value > kNoFlake ? value : 0;
}

double Vmf::sigma_of_cosine(double u) const {
  if (alpha_ == 0) return std::max(u, 0.0);
  const double back = back_sigma(std::min(std::abs(u), 1.0));
  return u > 0 ? back + u * mean_cosine_ : back;
}

double Vmf::density_of(Direction h) const {
  if (is_delta()) return 0;
  return vmf_density(kappa_, std::min(dot(h, axis_) / length(h), 1.0));
}

Vmf::MirrorLobe Vmf::mirror_lobe(Direction wi) const {
  const double area = is_delta() ? 0 : sigma(wi);
  // vmf_density(kappa, 1), by coth(kappa), which the mean cosine has.
  const double at_axis = (kappa_ * (1 + mean_cosine_) + 1) / (4 * kPi);
  return {*this, wi, area > kUnderflow ? at_axis / (4 * area) : 0};
}

double Vmf::mirror_phase(Direction wi, Direction wo) const {
  if (is_delta()) return 0;
  const Direction h = half_vector(wi, wo);
  const double area = sigma(wi);
  if (area > kUnderflow) return density_of(h) / (4 * area);
  const double u = std::clamp(dot(wi, axis_), -1.0, 1.0);
  const double log_sigma = log_vmf_sigma(u, alpha_);
  if (log_sigma < kNothing) return 0;
  // Rounding must not lift the normal above all that face w_i.
  const double peak = u < 0 ? -u * u / (1 + std::sqrt((1 - u) * (1 + u))) : 0;
  const double log_density = std::log(normalisation(kappa_) / (2 * kPi)) +
                             kappa_ * std::min(dot(h, axis_) / length(h) - 1, peak);
  return std::exp(log_density - log_sigma) / 4;
}

double Vmf::diffuse_phase(Direction wi, Direction wo) const {
  const double ui = std::clamp(dot(wi, axis_), -1.0, 1.0);
  const double uo = std::clamp(dot(wo, axis_), -1.0, 1.0);
  if (is_delta()) return ui > 0 ? std::max(uo, 0.0) / kPi : 0;
  if (alpha_ < kNarrow) {
    if (ui >= 0) return std::max(uo, 0.0) / kPi;
    const Direction edge = axis_ - ui * wi;
    const double norm = length(edge);
    return norm > 0 ? std::max(dot(wo, edge) / norm, 0.0) / kPi : 0;
  }
  const ClampedCosines pair(wi, wo, axis_);
  // Only v <= top faces w_i; relative to the density there nothing underflows.
  const double top = ui >= 0 ? 1 : pair.sine_i();
  const double log_sigma = log_vmf_sigma(ui, alpha_);
  if (log_sigma < kNothing) return 0;
  const double scale = normalisation(kappa_) / (2 * kPi) * std::exp(kappa_ * (top - 1) - log_sigma);
  std::vector<double> breaks;
  for (const double kink : pair.kinks()) breaks.insert(breaks.end(), {kink, -kink});
  // Panels over which the exponential falls by no more than exp(-8); beyond exp(-45), nothing.
  for (const double reach : {2.0, 8.0, 16.0, 24.0, 34.0})
    if (kappa_ > 0) breaks.push_back(top - reach / kappa_);
  const double bottom = kappa_ > 22.5 ? std::max(-1.0, top - 45 / kappa_) : -1;
  const auto integrand = [&](double v) { return std::exp(kappa_ * (v - top)) * pair.overlap(v); };
  // Opposite directions see nothing in common but rounding, of either sign.
  return std::max(scale * integrate_panels(integrand, bottom, top, std::move(breaks)), 0.0) / kPi;
}

Direction Vmf::sample_normal(RandomStream& stream) const {
  if (is_delta()) return axis_;
  const double u1 = stream.uniform(), u2 = stream.uniform();
  if (kappa_ == 0) return uniform_sphere(u1, u2);
  // 1 - cos, which neither narrow nor nearly uniform distributions round away
  const double below = std::min(-std::log1p(u1 * std::expm1(-2 * kappa_)) / kappa_, 2.0);
  const double r = std::sqrt(below * (2 - below)), phi = 2 * kPi * u2;
  return normalized(
      frame_around(axis_).to_world({r * std::cos(phi), r * std::sin(phi), 1 - below}));
}

Direction Vmf::visible_normal_by_null_collisions(Direction wi, RandomStream& stream) const {
  for (;;) {
    const Direction m = sample_normal(stream);
    if (stream.uniform() < dot(wi, m)) return m;
  }
}

Direction Vmf::visible_normal(Direction wi, RandomStream& stream) const {
  if (is_delta()) return axis_;
  const double u = dot(wi, axis_);
  if (u < 0) {
    const double s = std::sqrt(std::max(0.0, (1 - u) * (1 + u)));
    const double acceptance = sigma_of_cosine(u) / (s * side_ - u * back_);
    // Not a number where both underflow, straight from behind narrow flakes.
    if (!(acceptance >= 0.25)) return normal_from_behind(wi, u, stream);
  }
  // Where D itself is accepted often enough, its tries are the cheaper ones. (From the front sigma
  // is above its last term.)
  if (u * mean_cosine_ > kOftenSeen || sigma_of_cosine(u) > kOftenSeen)
    return normal_by_tries(wi, u, stream);
  return normal_by_mixture(wi, u, stream);
}

namespace {

// 1 - v for a cosine v in [0, 1] with density proportional to v exp(kappa v).
double axial_complement(double kappa, RandomStream& stream) {
  for (;;) {
    if (kappa < 2) {
      const double v = std::sqrt(stream.uniform());
      if (stream.uniform() < std::exp(kappa * (v - 1))) return 1 - v;
    } else {
      const double below = -std::log1p(stream.uniform() * std::expm1(-kappa)) / kappa;
      if (stream.uniform() < 1 - below) return below;
    }
  }
}

// x in [0, 1] with density proportional to x exp(-rate x).
double decaying_cosine(double rate, RandomStream& stream) {
  for (;;) {
    if (rate < 2) {
      const double x = std::sqrt(stream.uniform());
      if (stream.uniform() < std::exp(-rate * x)) return x;
    } else {
      const double x = (stream.exponential() + stream.exponential()) / rate;
      if (x <= 1) return x;
    }
  }
}

// 1 - v for a cosine v in [-1, 1] with density proportional to sqrt(1 - v^2) exp(kappa v). The
// complement, as v itself rounds to 1 for very narrow flakes.
double tangential_complement(double kappa, RandomStream& stream) {
  for (;;) {
    if (kappa < 1) {
      const double r = std::sqrt(stream.uniform());
      const double v = r * std::cos(2 * kPi * stream.uniform());
      if (stream.uniform() < std::exp(kappa * (v - 1))) return 1 - v;
    } else {
      const double c = std::cos(2 * kPi * stream.uniform());
      const double y = stream.exponential() * c * c + stream.exponential();  // Gamma(3/2)
      if (y >= 2 * kappa) continue;
      const double u = stream.uniform();
      if (u * u < 1 - y / (2 * kappa)) return y / kappa;
    }
  }
}

// Angle with density proportional to exp(kappa cos); Best and Fisher 1979, "Efficient simulation of
// the von Mises distribution", in the differences 1 - rho, r - 1, r - f and 1 - f so that it holds
// for any kappa.
double von_mises_angle(double kappa, RandomStream& stream) {
  if (kappa < 1e-8) return 2 * kPi * stream.uniform();
  const double root = std::hypot(1, 2 * kappa), tau = 1 + root;
  // rho = (tau - sqrt(2 tau)) / (2 kappa)
  const double gap = kappa > 1 ? (std::sqrt(2 * tau) - 1 - 1 / (2 * kappa + root)) / (2 * kappa)
                               : 1 - tau * (tau - 2) / ((tau + std::sqrt(2 * tau)) * 2 * kappa);
  const double excess = gap * gap / (2 * (1 - gap));  // r - 1, r = (1 + rho^2) / (2 rho)
  for (;;) {
    const double half = kPi / 2 * stream.uniform();
    const double above = 2 * std::cos(half) * std::cos(half);           // 1 + z
    const double below = 2 * std::sin(half) * std::sin(half);           // 1 - z
    const double c = kappa * excess * (excess + 2) / (excess + above);  // kappa (r - f)
    const double u = stream.uniform();
    if (c * (2 - c) > u || std::log(c / u) + 1 >= c) {
      const double fall = excess * below / (excess + above);  // 1 - f, f = (1 + r z) / (r + z)
      const double angle = 2 * std::asin(std::sqrt(std::min(fall / 2, 1.0)));
      return stream.uniform() < 0.5 ? angle : -angle;
    }
  }
}

// t in [0, 1] with density proportional to t exp(-a t - b t^2 / 2).
double gaussian_cosine(double a, double b, RandomStream& stream) {
  for (;;) {
    if (a < 2 && b < 4) {
      const double t = std::sqrt(stream.uniform());
      if (stream.uniform() < std::exp(-t * (a + b * t / 2))) return t;
    } else if (a * a > b) {
      const double t = (stream.exponential() + stream.exponential()) / a;
      if (t <= 1 && stream.uniform() < std::exp(-b * t * t / 2)) return t;
    } else {
      const double t = std::sqrt(2 * stream.exponential() / b);
      if (t <= 1 && stream.uniform() < std::exp(-a * t)) return t;
    }
  }
}

}  // namespace

Direction Vmf::normal_by_tries(Direction wi, double u, RandomStream& stream) const {
  const double s = std::sqrt(std::max(0.0, (1 - u) * (1 + u)));
  // 1 - exp(-2 kappa), by coth(kappa)
  const double range = 2 / (1 + mean_cosine_ + 1 / kappa_);
  // Nearly uniform normals would be rounded to none by the logarithm.
  const bool concentrated = kappa_ > 1e-3;
  for (;;) {
    const auto [u1, u2, accept, unused] = stream.four_uniforms();
    // 1 - z of a normal from D, as sample_normal has it.
    const double depth = concentrated ? -std::log(1 - u1 * range) : -std::log1p(-u1 * range);
    const double below = kappa_ > 0 ? std::min(depth / kappa_, 2.0) : 2 * u1;
    const double r = std::sqrt(below * (2 - below));
    const auto [sine, cosine] = sine_cosine_of_turns(u2);
    // x along the tangent of w_i
    const double x = r * cosine, z = 1 - below;
    if (accept >= u * z + s * x) continue;
    const Direction tangent = s > 1e-12 ? (1 / s) * (wi - u * axis_) : frame_around(axis_).s;
    return renormalized(x * tangent + r * sine * cross(axis_, tangent) + z * axis_);
  }
}

Direction Vmf::normal_by_mixture(Direction wi, double u, RandomStream& stream) const {
  const double s = std::sqrt(std::max(0.0, (1 - u) * (1 + u)));
  const Direction tangent = s > 1e-12 ? normalized(wi - u * axis_) : frame_around(axis_).s;
  const Direction binormal = cross(axis_, tangent);
  const VisibleNormalMixture<double> mixture{front_, back_, side_};
  const double axial = mixture.axial(u), total = mixture.majorant(u, s);
  for (;;) {
    const bool is_axial = stream.uniform() * total < axial;
    const double below = !is_axial ? tangential_complement(kappa_, stream)
                         : u < 0   ? 1 + decaying_cosine(kappa_, stream)
                                   : axial_complement(kappa_, stream);
    const Direction m = proposed_normal(is_axial, below, 2 * stream.uniform() - 1);
    if (takes_visible_normal(u, s, m, stream.uniform()))
      return renormalized(m.x * tangent + m.y * binormal + m.z * axis_);
  }
}

Direction Vmf::normal_from_behind(Direction wi, double u, RandomStream& stream) const {
  // In the frame of w_i, t = m.w_i: t exp(kappa u t + x) (exp(-x) I0(x)), x = kappa s sqrt(1 -
  // t^2), below t exp(-kappa |u| t - kappa s t^2 / 2) up to a constant; then the azimuth by von
  // Mises.
  const double s = std::sqrt(std::max(0.0, (1 - u) * (1 + u)));
  const Direction towards = s > 1e-12 ? normalized(axis_ - u * wi) : frame_around(wi).s;
  const Direction binormal = cross(wi, towards);
  // The product of exp(-x) I0(x) and the Gaussian's remainder is at most 1 / sqrt(1 + kappa s),
  // with equality at kappa s = 0 (a test scans it).
  for (;;) {
    const double t = gaussian_cosine(-kappa_ * u, kappa_ * s, stream);
    const double r = std::sqrt((1 - t) * (1 + t));
    const double x = kappa_ * s * r;
    // 1 - r - t^2 / 2 = t^2 / (1 + r) - t^2 / 2
    const double remainder = std::exp(-kappa_ * s * t * t * (1 / (1 + r) - 0.5));
    const double accept = remainder * scaled_bessel_i0(x) * std::sqrt(1 + kappa_ * s);
    if (stream.uniform() >= accept) continue;
    const double phi = von_mises_angle(x, stream);
    return normalized(t * wi + r * std::cos(phi) * towards + r * std::sin(phi) * binormal);
  }
}

double Vmf::largest_mirror_phase() const {
  // From behind, D of what faces w_i and sigma fall together.
  double largest = 0;
  const double width = std::min(1.0, 6 * alpha_);
  for (const double range : {1.0, width})
    for (double x = -1; x <= 1; x += 0x1p-7) {
      const double u = range * x, nearest = u < 0 ? std::sqrt((1 - u) * (1 + u)) : 1;
      const double area = std::max(vmf_sigma(u, alpha_), 1e-6);
      largest = std::max(largest, vmf_density(vmf_concentration(alpha_), nearest) / (4 * area));
    }
  return 2 * largest;
}

}  // namespace lamella
