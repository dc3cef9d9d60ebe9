#pragma once

#include <array>

#include "analytic/half_space/h_function.h"
#include "analytic/model/reflection_angles.h"

namespace lamella {

/// Phase function with its albedo folded in, p = 1 / (4 pi) sum over l of w[l] P_l(cos Theta), l
/// up to 2, Theta the deflection. w[0] in [0, 1] is the albedo.
using ThreeTermPhase = std::array<double, 3>;

/// The exact reflection of a half space with a three-term phase function:
///   f = f0(mu_i, mu_o) + f1(mu_i, mu_o) cos phi + f2(mu_i, mu_o) cos 2 phi [1/sr]
/// each fm a symmetric polynomial of the cosines times H_m(mu_i) H_m(mu_o) / (mu_i + mu_o).
///
/// Derivation. By the principle of invariance 4 pi (mu + mu') f0 = sum over l of
/// (-1)^l w_l psi_l(mu) psi_l(mu'), where psi_l = P_l + (-1)^l 2 pi mu * integral of f0 P_l, and
/// psi_l = q_l H_0 with q_l a polynomial of degree 2. So 4 pi (mu + mu') f0 = Q H_0 H_0 with
///   Q = A + B (x + y) + C x y + D x y (x + y) + E x^2 y^2 + F (x^2 + y^2),   Q(x, -x) = 2
///   Psi_0(x),
/// which gives A, E and C - 2 F. The integrals make q_l linear in Q, with moments of H_0; then
/// Q = sum (-1)^l w_l q_l q_l closes the system for B, D, F: two linear equations and a quadratic
/// one. f1 has one unknown, of a linear equation; f2 has none. The forms of f0 and f1 are those of
/// Horak and Chandrasekhar 1961 (d'Eon 2021, eqs. 27, 36).
/// Relative error below 1e-10 for 1 - w[0] = 0 or above 1e-8; in between, where two solutions
/// merge, 1e-14 / sqrt(1 - w[0]) and at most 1e-7.
class ThreeTermHalfSpace {
 public:
  explicit ThreeTermHalfSpace(ThreeTermPhase w);

  /// f_m, m = 0, 1, 2. Cosines in (0, 1].
  [[nodiscard]] double mode(int m, double mu_i, double mu_o) const;
  [[nodiscard]] double operator()(const ReflectionAngles& a) const;
  /// Directional albedo 1 - (q_1(mu) / mu) H_0(mu), of light from cosine mu.
  [[nodiscard]] double albedo(double mu) const;

  /// A, B, C, D, E, F above: twice those of d'Eon's eq. 36.
  [[nodiscard]] const std::array<double, 6>& mode_0_constants() const { return mode_0_; }
  /// The polynomial 1 + l (x + y) + n x y of f1 = -w1 H_1 H_1 sin sin / (4 pi (x + y)) times it,
  /// for w1 != 0.
  [[nodiscard]] double l() const { return w1_l_ / w_[1]; }
  [[nodiscard]] double n() const { return w1_n_ / w_[1]; }
  /// H_0, H_1, H_2.
  [[nodiscard]] const HFunction& h(int m) const { return h_[m]; }

 private:
  void solve_mode_0();
  void solve_mode_1();

  ThreeTermPhase w_;
  std::array<HFunction, 3> h_;
  std::array<double, 6> mode_0_{};
  std::array<double, 2> flux_{};  // q_1(mu) = flux[0] mu + flux[1] mu^2
  double w1_l_ = 0, w1_n_ = 0;
};

/// The Fourier coefficient of cos(m phi), m = 0, 1, 2, of p at cos Theta = x y + sqrt(1 - x^2)
/// sqrt(1 - y^2) cos phi, x and y cosines in [-1, 1] (d'Eon 2021, eqs. 8-12).
[[nodiscard]] double three_term_fourier(const ThreeTermPhase& w, int m, double x, double y);

/// Its single scattering, f = p(Theta) / (mu_i + mu_o), by mode.
[[nodiscard]] double three_term_single(const ThreeTermPhase& w, int m, double mu_i, double mu_o);
[[nodiscard]] double three_term_single(const ThreeTermPhase& w, const ReflectionAngles& a);

/// K_m(0) = product over l >= m of (1 - w_l / (2l + 1)), the k0 of mode m's HFunction.
[[nodiscard]] double three_term_k0(const ThreeTermPhase& w, int m);
/// The coefficients of mode m's characteristic function Psi_m in powers of mu^2.
[[nodiscard]] std::array<double, 3> three_term_characteristic(const ThreeTermPhase& w, int m);

}  // namespace lamella
