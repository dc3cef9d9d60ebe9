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

/// The same, computed once per thread and n.
[[nodiscard]] const Quadrature& cached_gauss_legendre(int n);

/// Cosines mu and weights for the integral over mu in (0, 1): Gauss-Legendre in x with mu = x^3.
/// Radiance inside a layer behaves like mu log mu and exp(-tau / mu) at grazing angles; the map
/// crowds the points there (the smallest is about 3 / n^6) and the integrand is smoother in x.
[[nodiscard]] Quadrature grazing_quadrature(int n);

/// sin of the angle whose cosine is mu.
[[nodiscard]] inline double sine(double mu) { return std::sqrt((1 - mu) * (1 + mu)); }

}  // namespace lamella
