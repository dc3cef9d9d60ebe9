#include "volume/quadrature/quadrature.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace lamella {

Quadrature gauss_legendre(int n) {
  Quadrature rule{Eigen::VectorXd(n), Eigen::VectorXd(n)};
  for (int k = 0; k < n; ++k) {
    double x = std::cos(std::numbers::pi * (k + 0.75) / (n + 0.5));
    double slope = 1;
    for (int step = 0; step < 20; ++step) {
      double before = 1, value = x;
      for (int l = 2; l <= n; ++l) {
        const double next = ((2 * l - 1) * x * value - (l - 1) * before) / l;
        before = value;
        value = next;
      }
      slope = n * (x * value - before) / ((x - 1) * (x + 1));
      const double change = value / slope;
      x -= change;
      if (std::abs(change) < 1e-16) break;
    }
    rule.points[k] = (1 - x) / 2;
    rule.weights[k] = 1 / ((1 - x) * (1 + x) * slope * slope);
  }
  return rule;
}

const Quadrature& cached_gauss_legendre(int n) {
  thread_local std::map<int, Quadrature> rules;
  const auto it = rules.find(n);
  return it != rules.end() ? it->second : rules.emplace(n, gauss_legendre(n)).first->second;
}

namespace {

// t - atan t, by its series where they cancel.
double beyond_arctangent(double t) {
  const double t2 = t * t;
  if (t < 0.05) return t * t2 * (1 / 3. - t2 * (1 / 5. - t2 * (1 / 7. - t2 * (1 / 9. - t2 / 11))));
  return t - std::atan(t);
}

}  // namespace

GrazingMap::GrazingMap(double knee) : knee_(knee), scale_(1 / beyond_arctangent(1 / knee)) {}

double GrazingMap::mu(double u) const {
  return knee_ > 0 ? scale_ * beyond_arctangent(u / knee_) : u * u * u;
}

double GrazingMap::slope(double u) const {
  return knee_ > 0 ? scale_ / knee_ * u * u / (u * u + knee_ * knee_) : 3 * u * u;
}

double GrazingMap::parameter(double mu) const {
  // The library's cube root of 1 - 2^-52 is above 1, where cosines would have no sine.
  if (!(knee_ > 0)) return std::min(1.0, std::cbrt(mu));
  // The map is convex: Newton's method from above falls onto the root.
  double u = std::min(1.0, std::max(std::cbrt(3 * mu / scale_) * knee_, mu + knee_ * (1 - mu)));
  for (int step = 0; step < 60 && u > 0; ++step) {
    const double change = (this->mu(u) - mu) / slope(u);
    u -= change;
    if (std::abs(change) <= 1e-16 * u) break;
  }
  return u;
}

Quadrature grazing_quadrature(int n, const GrazingMap& map) {
  Quadrature rule = gauss_legendre(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    rule.weights[k] *= map.slope(rule.points[k]);
    rule.points[k] = map.mu(rule.points[k]);
  }
  return rule;
}

}  // namespace lamella
