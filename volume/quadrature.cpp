#include "volume/quadrature.h"

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

Quadrature grazing_quadrature(int n) {
  Quadrature rule = gauss_legendre(n);
  const Eigen::ArrayXd x = rule.points.array();
  rule.weights.array() *= 3 * x.square();
  rule.points = x.cube();
  return rule;
}

}  // namespace lamella
