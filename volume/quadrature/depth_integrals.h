#pragma once

namespace lamella {

/// Integrals over a layer of depth D (infinity allowed) of chains of exponentials: mean values of
/// the divided differences of exp(-x). Rates are per unit of depth and >= 0; relative error below
/// 1e-13, with no cancellation where rates are equal, 0 or very large.

/// Integral over 0 < t < D of exp(-x t).
[[nodiscard]] double decay_integral(double x, double depth);
/// Integral over 0 < t < D of exp(-x t) exp(-y (D - t)); 0 at D infinite.
[[nodiscard]] double crossing_integral(double x, double y, double depth);
/// Integral over s, t > 0, s + t < D of exp(-x s) exp(-y t).
[[nodiscard]] double decay_integral(double x, double y, double depth);
/// Integral over s, t, u > 0, s + t + u = D of exp(-x s) exp(-y t) exp(-z u); 0 at D infinite.
[[nodiscard]] double crossing_integral(double x, double y, double z, double depth);

}  // namespace lamella
