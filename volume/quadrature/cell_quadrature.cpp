#include "volume/quadrature/cell_quadrature.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>

#include "volume/quadrature/quadrature.h"

namespace lamella {
namespace {

constexpr int kMaxParts = 4000;
constexpr int kPeakHalvings = 7;
// Strips towards mu = 0, where f may vary like 1 / (mu_i + mu) with a small mu_i.
constexpr int kGrazingStrips = 4;

using Function = std::function<Rgb(double mu, double phi)>;

// The elevation e, mu = sin e, as a function of t: t itself, or, beside a kink, a distance from it
// of t^4, t from 0 to 1: the root of the distance is smooth in t then.
struct Elevation {
  double kink = 0, length = 0;  // length: signed, to the other end; 0: e = t

  [[nodiscard]] double at(double t) const {
    return length == 0 ? t : kink + length * t * t * t * t;
  }
  [[nodiscard]] double slope(double t) const {
    return length == 0 ? 1 : 4 * std::abs(length) * t * t * t;
  }
};

struct AngleRange {
  double t0, t1, phi0, phi1;
  Elevation elevation = {};
};

Rgb absolute(Rgb x) { return {std::abs(x.r), std::abs(x.g), std::abs(x.b)}; }

// Integral of f mu dmu dphi, in the elevation e, mu = sin e: f depends on the sine of the polar
// angle, too, which is a smooth function of the angle only.
Rgb integral(const Function& f, const AngleRange& r, int points) {
  const Quadrature& rule = cached_gauss_legendre(points);
  Rgb sum;
  for (int a = 0; a < points; ++a) {
    const double t = r.t0 + (r.t1 - r.t0) * rule.points[a];
    const double e = r.elevation.at(t), mu = std::sin(e), slope = r.elevation.slope(t);
    for (int b = 0; b < points; ++b)
      sum += rule.weights[a] * rule.weights[b] * mu * std::cos(e) * slope *
             f(mu, r.phi0 + (r.phi1 - r.phi0) * rule.points[b]);
  }
  return (r.t1 - r.t0) * (r.phi1 - r.phi0) * sum;
}

struct Part {
  AngleRange range;
  Rgb value, error;
  double excess;  // largest error over what is allowed

  friend bool operator<(const Part& a, const Part& b) { return a.excess < b.excess; }
};

std::array<AngleRange, 4> quarters(const AngleRange& r) {
  const double t = (r.t0 + r.t1) / 2, phi = (r.phi0 + r.phi1) / 2;
  return {{{r.t0, t, r.phi0, phi, r.elevation},
           {r.t0, t, phi, r.phi1, r.elevation},
           {t, r.t1, r.phi0, phi, r.elevation},
           {t, r.t1, phi, r.phi1, r.elevation}}};
}

bool holds(const AngleRange& r, std::pair<double, double> peak) {
  constexpr double kEdge = 1e-12;
  const auto [low, high] = std::minmax({r.elevation.at(r.t0), r.elevation.at(r.t1)});
  return peak.first >= low - kEdge && peak.first <= high + kEdge && peak.second >= r.phi0 - kEdge &&
         peak.second <= r.phi1 + kEdge;
}

}  // namespace

CellMean cell_mean(const Function& f, const MuPhiRange& range, Rgb tolerance,
                   const std::vector<std::pair<double, double>>& peaks,
                   const std::vector<double>& kinks) {
  const double size =
      (range.mu1 - range.mu0) * (range.mu1 + range.mu0) / 2 * (range.phi1 - range.phi0);
  std::priority_queue<Part> parts;
  Rgb value, error;
  const auto add = [&](const AngleRange& r) {
    Part part{r, integral(f, r, 4), {}, 0};
    // Twice, because the two rules may be off the same way where f is not smooth.
    part.error = 2 * absolute(part.value - integral(f, r, 3));
    for (int c = 0; c < 3; ++c)
      part.excess = std::max(part.excess, part.error[c] / std::max(tolerance[c], 1e-300));
    value += part.value;
    error += part.error;
    parts.push(part);
  };
  // Adds a range in parts that shrink towards the peaks in it.
  const std::function<void(const AngleRange&, int)> add_halved = [&](const AngleRange& r,
                                                                     int halvings) {
    const bool sharp = std::any_of(peaks.begin(), peaks.end(), [&](const auto& peak) {
      return holds(r, {std::asin(peak.first), peak.second});
    });
    if (!sharp || halvings == 0) return add(r);
    for (const AngleRange& quarter : quarters(r)) add_halved(quarter, halvings - 1);
  };
  // From one end to the other without a kink between; strips towards grazing.
  const auto add_smooth = [&](double e0, double e1) {
    for (int strip = 1; e0 == 0 && strip < kGrazingStrips; ++strip, e1 /= 2)
      add_halved({e1 / 2, e1, range.phi0, range.phi1}, kPeakHalvings);
    add_halved({e0, e1, range.phi0, range.phi1}, kPeakHalvings);
  };
  const auto add_beside = [&](double kink, double end) {
    add_halved({0, 1, range.phi0, range.phi1, {kink, end - kink}}, kPeakHalvings);
  };
  constexpr double kSame = 1e-9;  // elevations
  const double low = std::asin(range.mu0), high = std::asin(range.mu1);
  double from = low;
  bool from_kink = false;
  const auto add_piece = [&](double to, bool to_kink) {
    const double middle = (from + to) / 2;
    if (to - from < kSame) return;
    if (from_kink) add_beside(from, to_kink ? middle : to);
    if (to_kink) add_beside(to, from_kink || from == 0 ? middle : from);
    if (!from_kink && (!to_kink || from == 0)) add_smooth(from, to_kink ? middle : to);
  };
  for (const double kink : kinks) {
    const double e = std::asin(kink);
    if (e < low - kSame || e > high + kSame) continue;
    const double inside = std::clamp(e, low, high);
    add_piece(inside, true);
    from = inside;
    from_kink = true;
  }
  add_piece(high, false);
  CellMean mean;
  const auto within = [&] {
    for (int c = 0; c < 3; ++c)
      if (error[c] > tolerance[c] * size) return false;
    return true;
  };
  while (!within()) {
    if (parts.size() >= kMaxParts) {
      mean.exhausted = true;
      break;
    }
    const Part worst = parts.top();
    parts.pop();
    value += -1.0 * worst.value;
    error += -1.0 * worst.error;
    for (const AngleRange& quarter : quarters(worst.range)) add(quarter);
  }
  // Sums anew: adding and taking away leaves rounding.
  value = error = Rgb();
  for (; !parts.empty(); parts.pop()) {
    value += parts.top().value;
    error += parts.top().error;
  }
  mean.value = 1 / size * value;
  mean.error = 1 / size * error;
  return mean;
}

}  // namespace lamella
