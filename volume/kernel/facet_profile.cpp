#include "volume/kernel/facet_profile.h"

#include <algorithm>
#include <cmath>

#include "phase/math/direction.h"
#include "phase/surface/fresnel_formulas.h"

namespace lamella {
namespace {

using Eigen::ArrayXd;

double chord2(double x) {
  const double s = std::sin(x / 2);
  return 4 * s * s;
}

// Few different rules, each of which is kept.
int rounded_up(double points) { return (static_cast<int>(points) / 8 + 1) * 8; }

// Gauss-Legendre in t on (0, stretch), x = b sinh t: dense about 0 where f peaks, with points
// enough for the cosines of the modes.
template <class Add>
void from_peak(double end, double b, int modes, const Add& add) {
  const double stretch = std::asinh(end / b);
  const int n = rounded_up(20 + 5 * stretch + 0.28 * modes * end * std::max(1.0, stretch));
  const Quadrature& rule = cached_gauss_legendre(n);
  for (int k = 0; k < n; ++k) {
    const double e = std::exp(stretch * rule.points[k]);
    add(b * (e - 1 / e) / 2, rule.weights[k] * stretch * b * (e + 1 / e) / 2);
  }
}

// On (start, end), where f goes like a square root from the start: x = start + z^2, z = b' sinh t.
template <class Add>
void from_root(double start, double end, double b, int modes, const Add& add) {
  const double length = std::sqrt(end - start), near = std::sqrt(std::hypot(b, start));
  const double stretch = std::asinh(length / near);
  const int n = rounded_up(24 + 6 * stretch + 0.5 * modes * (end - start) * std::max(1.0, stretch));
  const Quadrature& rule = cached_gauss_legendre(n);
  for (int k = 0; k < n; ++k) {
    const double e = std::exp(stretch * rule.points[k]), z = near * (e - 1 / e) / 2;
    add(start + z * z, rule.weights[k] * stretch * near * (e + 1 / e) * z);
  }
}

}  // namespace

FacetProfile::FacetProfile(const Facets& facets, Masking masking, double ratio)
    : facets_(facets), masking_(masking), ratio_(ratio) {}

FacetProfile::Pair FacetProfile::pair_of(double mu_i, double mu_o) const {
  const double si = sine(mu_i), so = sine(mu_o);
  Pair pair{};
  pair.end = kPi;
  if (ratio_ == 0) {
    const double sum = si + so, difference = sum > 0 ? (mu_o - mu_i) * (mu_o + mu_i) / sum : 0;
    pair.hz = mu_i + mu_o;
    pair.gap = difference * difference;
    pair.product = si * so;
    if (critical_ > 0 && pair.product > 0) {
      // |h| / 2 is the cosine of incidence.
      const double sin2 =
          (4 * critical_ * critical_ - pair.hz * pair.hz - pair.gap) / (4 * pair.product);
      if (sin2 >= 1)
        pair.critical = kPi;
      else if (sin2 > 0)
        pair.critical = 2 * std::asin(std::sqrt(sin2));
    }
    return pair;
  }
  const double difference = si - ratio_ * so;
  pair.hz = ratio_ * mu_o - mu_i;
  pair.gap = difference * difference;
  pair.product = ratio_ * si * so;
  if (!(pair.hz > 0)) {
    pair.end = 0;
    return pair;
  }
  // Light meets the facet's front where cos x exceeds this.
  const double least = 1 / ratio_ - mu_i * mu_o;
  if (least >= si * so)
    pair.end = 0;
  else if (least > -si * so)
    pair.end = std::acos(least / (si * so));
  return pair;
}

double FacetProfile::value(const Pair& pair, double mu_i, double mu_o, double x) const {
  const double chord = chord2(x);
  const double hxy2 = pair.gap + pair.product * chord, hz2 = pair.hz * pair.hz;
  const double h2 = hxy2 + hz2;
  if (!(h2 > 0)) return 0;
  const double alpha2 = facets_.alpha_x * facets_.alpha_x;
  double density = 0;
  if (facets_.shape == FacetShape::ggx) {
    const double t = h2 / (hxy2 / alpha2 + hz2);
    density = t * t / (kPi * alpha2);
  } else {
    const double t = h2 / hz2;
    density = std::exp(-hxy2 / (hz2 * alpha2)) * t * t / (kPi * alpha2);
  }
  if (ratio_ == 0) return density / 4 * reflectance_(std::min(1.0, std::sqrt(h2) / 2));
  const double h = std::sqrt(h2);
  // w_i . w_o
  const double c = -sine(mu_i) * sine(mu_o) * (1 - chord / 2) - mu_i * mu_o;
  const double ci = -(1 + ratio_ * c) / h, co = -(c + ratio_) / h;
  if (!(ci > 0)) return 0;
  return (1 - refraction(std::min(ci, 1.0), ratio_).reflectance) * density * ci * ratio_ * ratio_ *
         -co / h2;
}

void FacetProfile::modes(double mu_i, double mu_o, ArrayXd& result) const {
  result.setZero();
  const Pair pair = pair_of(mu_i, mu_o);
  if (pair.end == 0) return;
  const double masked =
      facets_.shadowing(masking_, ratio_ != 0, {sine(mu_i), 0, mu_i}, {sine(mu_o), 0, mu_o});
  if (!(masked > 0)) return;
  const int count = static_cast<int>(result.size());
  // Of GGX's singularity; Beckmann's peak is as wide.
  const double alpha = facets_.alpha_x;
  const double b =
      std::clamp(std::sqrt((pair.gap + std::min(1.0, alpha * alpha) * pair.hz * pair.hz) /
                           std::max(pair.product, 1e-300)),
                 1e-7, 2.0);
  thread_local std::vector<double> xs, ws;
  xs.clear();
  ws.clear();
  const auto add = [&](double x, double weight) {
    xs.push_back(x);
    ws.push_back(weight * value(pair, mu_i, mu_o, x));
  };
  if (pair.critical) {
    from_peak(*pair.critical, std::min(b, *pair.critical), count, add);
    if (*pair.critical < pair.end) from_root(*pair.critical, pair.end, b, count, add);
  } else {
    from_peak(pair.end, std::min(b, pair.end), count, add);
  }
  const Eigen::Index n = static_cast<Eigen::Index>(xs.size());
  const ArrayXd x = Eigen::Map<const ArrayXd>(xs.data(), n);
  ArrayXd now = Eigen::Map<const ArrayXd>(ws.data(), n) * (masked / kPi);
  const ArrayXd step = 2 * x.cos();
  ArrayXd before = now * step / 2, next;
  for (int m = 0; m < count; ++m) {
    result[m] = now.sum();
    next = step * now - before;
    before.swap(now);
    now.swap(next);
  }
}

FacetProfile::Places FacetProfile::places(double mu, bool given_is_in) const {
  const double theta = std::acos(std::clamp(mu, 0.0, 1.0));
  const double alpha = std::min(1.0, facets_.alpha_x);
  Places places;
  const auto edge = [&](double at) {
    if (at > 0 && at < kPi / 2) places.edges.push_back(at);
  };
  if (ratio_ == 0) {
    places.peak = theta;
    places.width = alpha;
    if (critical_ > 0) {
      // Where the mirror facet of some azimuth is at the critical angle.
      const double limit = 2 * std::acos(critical_);
      edge(theta - limit);
      edge(theta + limit);
      edge(limit - theta);
    }
    return places;
  }
  const double cone = std::acos(1 / ratio_);
  edge(theta - cone);
  edge(theta + cone);
  edge(cone - theta);
  const double deflection = alpha * (1 - 1 / ratio_);
  if (given_is_in) {
    places.peak = std::asin(sine(mu) / ratio_);
    places.width = deflection;
    edge(std::acos(mu / ratio_));  // facets stand upright
  } else {
    const double s = ratio_ * sine(mu);
    places.peak = s < 1 ? std::asin(s) : kPi / 2;
    places.width = deflection * ratio_;
    if (ratio_ * mu < 1) edge(std::acos(ratio_ * mu));
  }
  return places;
}

}  // namespace lamella
