#include "volume/quadrature/depth_integrals.h"

#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

// (1 - exp(-x)) / x
double mean_decay(double x) { return x == 0 ? 1 : -std::expm1(-x) / x; }

// Integral over s, t > 0, s + t < 1 of exp(-p s - q t): the divided difference of exp(-x) over
// 0, p, q.
double over_triangle(double p, double q) {
  if (p > q) std::swap(p, q);
  // Divided by the largest difference, numerator not small.
  if (q >= 1) return (mean_decay(p) - std::exp(-p) * mean_decay(q - p)) / q;
  // Sum over n of (-1)^n h_n(p, q) / (n + 2)!, h_n the sum of p^k q^(n - k).
  double sum = 0, h = 1, power = 1, factorial = 2;
  for (int n = 0; n < 18; ++n) {
    sum += (n % 2 ? -h : h) / factorial;
    power *= q;
    h = h * p + power;
    factorial *= n + 3;
  }
  return sum;
}

}  // namespace

double decay_integral(double x, double depth) {
  return std::isinf(depth) ? 1 / x : depth * mean_decay(x * depth);
}

double crossing_integral(double x, double y, double depth) {
  if (std::isinf(depth)) return 0;
  return depth * std::exp(-std::min(x, y) * depth) * mean_decay(std::abs(x - y) * depth);
}

double decay_integral(double x, double y, double depth) {
  return std::isinf(depth) ? 1 / (x * y) : depth * depth * over_triangle(x * depth, y * depth);
}

double crossing_integral(double x, double y, double z, double depth) {
  if (std::isinf(depth)) return 0;
  const double least = std::min({x, y, z}), most = std::max({x, y, z});
  const double middle = std::max(std::min(x, y), std::min(std::max(x, y), z));
  return depth * depth * std::exp(-least * depth) *
         over_triangle((middle - least) * depth, (most - least) * depth);
}

}  // namespace lamella
