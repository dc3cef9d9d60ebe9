#pragma once

#include <Eigen/Core>
#include <cmath>

namespace lamella {

/// Points and weights of a quadrature rule on (0, 1).
struct Quadrature {
  Eigen::VectorXd points, weights;
};

/// Gauss-Legendre on (0, 1): exact for polynomials of degree 2 n - 1. Newton's method on the
/// Legendre recurrence; points and weights to about 1e-15. n >= 1.
[[nodiscard]] Quadrature gauss_legendre(int n);

/// The rule of gauss_legendre(n), computed once per thread and n.
[[nodiscard]] const Quadrature& cached_gauss_legendre(int n);

/// A parameter u in [0, 1] of the cosine mu. Radiance inside a layer behaves like mu log mu and
/// exp(-tau / mu) at grazing angles and is smoother in u, as mu ~ u^3 there. With a knee this holds
/// below the knee only; beyond it mu is linear in u, so the points spread more evenly over the
/// angle, as peaks that are narrow at every angle need. Without a knee mu = u^3 everywhere.
class GrazingMap {
 public:
  GrazingMap() = default;
  /// knee > 0: d mu / du is proportional to u^2 / (u^2 + knee^2).
  explicit GrazingMap(double knee);

  [[nodiscard]] double mu(double u) const;
  [[nodiscard]] double slope(double u) const;  ///< d mu / du
  [[nodiscard]] double parameter(double mu) const;

 private:
  double knee_ = 0;  // 0: none
  double scale_ = 1;
};

/// Cosines mu and weights for the integral over mu in (0, 1): Gauss-Legendre in the map's u. With
/// n points the smallest mu is about 3 / n^6 without a knee.
[[nodiscard]] Quadrature grazing_quadrature(int n, const GrazingMap& map = {});

/// sin of the angle whose cosine is mu.
[[nodiscard]] inline double sine(double mu) { return std::sqrt((1 - mu) * (1 + mu)); }

}  // namespace lamella
