#include "volume/harmonics/flake_events.h"

#include <algorithm>
#include <cmath>

#include "phase/math/color.h"
#include "phase/math/direction.h"

namespace lamella {

using Eigen::MatrixXd;
using Eigen::VectorXd;

Quadrature flake_angles(const std::vector<double>& places, double width, int degree) {
  std::vector<double> edges{0, kPi};
  for (const double place : places) {
    edges.push_back(place);
    for (double distance = width / 2; distance < kPi; distance *= 2) {
      edges.push_back(std::clamp(place - distance, 0.0, kPi));
      edges.push_back(std::clamp(place + distance, 0.0, kPi));
    }
  }
  std::sort(edges.begin(), edges.end());
  std::vector<double> points, weights;
  for (std::size_t k = 0; k + 1 < edges.size(); ++k) {
    const double length = edges[k + 1] - edges[k];
    if (length < 1e-12) continue;
    // Waves of up to twice the degree: half a phase of (2 degree + 1) length / 2 per unit.
    const Quadrature& rule =
        cached_gauss_legendre(16 + static_cast<int>(0.6 * (degree + 1) * length));
    for (Eigen::Index j = 0; j < rule.points.size(); ++j) {
      points.push_back(edges[k] + length * rule.points[j]);
      weights.push_back(length * rule.weights[j]);
    }
  }
  return {Eigen::Map<VectorXd>(points.data(), static_cast<Eigen::Index>(points.size())),
          Eigen::Map<VectorXd>(weights.data(), static_cast<Eigen::Index>(weights.size()))};
}

VectorXd clamped_cosine_factors(const HarmonicBasis& basis) {
  const int degree = basis.degree();
  const Quadrature& half = cached_gauss_legendre(degree + 4);
  VectorXd values(basis.size()), clamped = VectorXd::Zero(degree + 1);
  for (Eigen::Index k = 0; k < half.points.size(); ++k) {
    basis.legendre(half.points[k], values);
    for (int l = 0; l <= degree; ++l)
      clamped[l] +=
          2 * kPi * half.weights[k] * half.points[k] * values[l] * std::sqrt(4 * kPi / (2 * l + 1));
  }
  return clamped;
}

std::vector<MatrixXd> one_mirror(double f0, const HarmonicBasis& basis) {
  const int degree = basis.degree();
  const Quadrature& half = cached_gauss_legendre(degree + 6);
  std::vector<MatrixXd> one(degree + 1);
  {
    std::vector<MatrixXd> legendre(degree + 1);
    for (int m = 0; m <= degree; ++m) legendre[m].resize(basis.count(m), half.points.size());
    VectorXd values(basis.size()), weights(half.points.size());
    for (Eigen::Index k = 0; k < half.points.size(); ++k) {
      const double t = half.points[k];
      basis.legendre(t, values);
      for (int m = 0; m <= degree; ++m)
        legendre[m].col(k) = values.segment(basis.first(m, false), basis.count(m));
      weights[k] = 2 * kPi * half.weights[k] * t * (f0 + (1 - f0) * schlick_weight(t));
    }
    for (int m = 0; m <= degree; ++m)
      one[m] = (m % 2 ? -1 : 1) * legendre[m] * weights.asDiagonal() * legendre[m].transpose();
  }
  return one;
}

}  // namespace lamella
