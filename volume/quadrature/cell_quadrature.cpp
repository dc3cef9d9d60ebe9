#include "volume/quadrature/cell_quadrature.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>

#include "volume/quadrature/quadrature.h"

namespace lamella {
namespace {

constexpr int kMaxParts = 4000;
constexpr int kPeakHalvings = 7, kMostHalvings = 48;
constexpr double kEdge = 1e-12;
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

  // The lower one first.
  [[nodiscard]] std::pair<double, double> elevations() const {
    return std::minmax({elevation.at(t0), elevation.at(t1)});
  }
  [[nodiscard]] bool touches(double phi, double margin = kEdge) const {
    return phi >= phi0 - margin && phi <= phi1 + margin;
  }
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
  const auto [low, high] = r.elevations();
  return peak.first >= low - kEdge && peak.first <= high + kEdge && r.touches(peak.second);
}

// Within a few widths of a lobe that peaks there.
bool is_near(const AngleRange& r, const Ridge& ridge,
             const std::vector<std::pair<double, double>>& peaks) {
  constexpr double kWidths = 4;
  const auto [low, high] = r.elevations();
  return std::any_of(peaks.begin(), peaks.end(), [&, low = low, high = high](const auto& peak) {
    const double e = std::asin(peak.first);
    return e >= low - kWidths * ridge.length && e <= high + kWidths * ridge.length &&
           r.touches(peak.second, kWidths * ridge.width);
  });
}

}  // namespace

CellMean cell_mean(const Function& f, const MuPhiRange& range, Rgb tolerance,
                   const std::vector<std::pair<double, double>>& peaks,
                   const std::vector<double>& kinks, const Ridge& ridge) {
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
  // Adds a range in parts that are as small as the lobe about its peak, and as narrow on the ridge.
  const std::function<void(const AngleRange&, int)> add_ridged = [&](const AngleRange& r,
                                                                     int halvings) {
    const auto [low, high] = r.elevations();
    const bool near = is_near(r, ridge, peaks);
    const bool across = near && high - low > ridge.length;
    const bool along = (near || r.touches(ridge.phi)) && r.phi1 - r.phi0 > ridge.width;
    if (halvings == 0 || !(across || along)) return add(r);
    AngleRange first = r, second = r;
    if (across)
      first.t1 = second.t0 = (r.t0 + r.t1) / 2;
    else
      first.phi1 = second.phi0 = (r.phi0 + r.phi1) / 2;
    add_ridged(first, halvings - 1);
    add_ridged(second, halvings - 1);
  };
  const auto add_sharp = [&](const AngleRange& r) {
    ridge.width > 0 ? add_ridged(r, kMostHalvings) : add_halved(r, kPeakHalvings);
  };
  // From one end to the other without a kink between; strips towards grazing.
  const auto add_smooth = [&](double e0, double e1) {
    for (int strip = 1; e0 == 0 && strip < kGrazingStrips; ++strip, e1 /= 2)
      add_sharp({e1 / 2, e1, range.phi0, range.phi1});
    add_sharp({e0, e1, range.phi0, range.phi1});
  };
  const auto add_beside = [&](double kink, double end) {
    add_sharp({0, 1, range.phi0, range.phi1, {kink, end - kink}});
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
