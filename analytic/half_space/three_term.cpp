#include "analytic/half_space/three_term.h"

#include <algorithm>
#include <cmath>

#include "analytic/half_space/three_term_formula.h"

namespace lamella {
namespace {

/// The system of the azimuthal mean: see three_term.h. Everything is written in the numbers that
/// vanish with 1 - c, so that the conservative case needs no other formulas.
struct ModeZero {
  struct Q {
    double a, b, c, d, e, f;
  };

  ThreeTermPhase w;
  std::array<double, 3> psi;
  std::array<double, 6> h;   // moments of H_0
  std::array<double, 4> p2;  // moments of P_2 H_0
  double root_k0;            // 1 - integral of Psi_0 H_0
  double gap;                // psi[1] + 3/8 w_2, of the order of 1 - c
  double beta, x;            // factors of the two linear equations

  ModeZero(const ThreeTermPhase& w_, const HFunction& h0)
      : w(w_), psi(three_term_characteristic(w_, 0)), root_k0(std::sqrt(three_term_k0(w_, 0))) {
    for (int k = 0; k < 6; ++k) h[k] = h0.moment(k);
    for (int k = 0; k < 4; ++k) p2[k] = (3 * h[k + 2] - h[k]) / 2;
    gap = (1 - w[0]) * (w[1] - w[2] * (3 - w[1]) / 4) / 2;
    beta = root_k0 + gap * h[2] + psi[2] * h[4];
    x = psi[0] * h[1] - 0.375 * w[2] * h[3];
  }

  /// All constants from B. The coefficients of x and x^2 in Q(x, 0) = w_0 q_0(x) - w_2 / 2 q_2(x)
  /// give F and D.
  [[nodiscard]] Q constants(double b) const {
    const double a = 2 * psi[0];
    const double f = (beta * b + a * (h[1] * gap + psi[2] * h[3])) / x;
    const double d =
        (beta * f - psi[2] * (a * h[2] - 0.75 * w[2] * h[4]) + 0.75 * w[2] * root_k0) / x;
    return {a, b, 2 * f - 2 * psi[1], d, 2 * psi[2], f};
  }

  /// q_l = q[l][0] + q[l][1] mu + q[l][2] mu^2.
  [[nodiscard]] std::array<std::array<double, 3>, 3> polynomials(const Q& q) const {
    const double cf = q.c - q.f;
    const double psi_1 = psi[0] * h[1] + psi[1] * h[3] + psi[2] * h[5];
    return {
        {{1, (q.b * h[0] + cf * h[1] - q.e * h[3]) / 2, (q.d * h[1] + q.f * h[0] + q.e * h[2]) / 2},
         {0, root_k0 - (q.b * h[1] + cf * h[2] - q.e * h[4]) / 2,
          -(q.d * h[2] + q.f * h[1] + q.e * h[3]) / 2},
         {-0.5, 1.5 * psi_1 + (q.b * p2[0] + cf * p2[1] - q.e * p2[3]) / 2,
          1.5 * root_k0 + (q.d * p2[1] + q.f * p2[0] + q.e * p2[2]) / 2}}};
  }

  /// The coefficient of x^i y^j in sum (-1)^l w_l q_l(x) q_l(y), which is to be Q.
  [[nodiscard]] double product(const std::array<std::array<double, 3>, 3>& p, int i, int j) const {
    return w[0] * p[0][i] * p[0][j] - w[1] * p[1][i] * p[1][j] + w[2] * p[2][i] * p[2][j];
  }

  /// For small albedo: scattering order by scattering order.
  [[nodiscard]] Q solve_by_iteration() const {
    Q q{2 * psi[0], 0, -2 * psi[1], 0, 2 * psi[2], 0};
    for (int step = 0; step < 200; ++step) {
      const auto p = polynomials(q);
      const Q last = q;
      q.b = product(p, 1, 0);
      q.d = product(p, 2, 1);
      q.f = product(p, 2, 0);
      q.c = 2 * q.f - 2 * psi[1];
      if (q.b == last.b && q.d == last.d && q.f == last.f) break;
    }
    return q;
  }

  /// For large albedo: the coefficient of x y is a quadratic equation for B. Of its zeros, the one
  /// at which q_1 > 0, so that the albedo is below 1; the other one has q_1 with the opposite sign,
  /// which the square does not see. At c = 1 they are one.
  [[nodiscard]] Q solve_directly() const {
    const auto excess = [&](double b) {
      const Q q = constants(b);
      return product(polynomials(q), 1, 1) - q.c;
    };
    const double e0 = excess(0), up = excess(1), down = excess(-1);
    const double a = (up + down) / 2 - e0, half = (up - down) / 4;
    const double root = root_k0 == 0 ? 0 : std::sqrt(std::max(0.0, half * half - a * e0));
    const Q first = constants((-half + root) / a), second = constants((-half - root) / a);
    return polynomials(first)[1][1] > polynomials(second)[1][1] ? first : second;
  }
};

}  // namespace

double three_term_k0(const ThreeTermPhase& w, int m) {
  double product = 1;
  for (int l = m; l < 3; ++l) product *= 1 - w[l] / (2 * l + 1);
  return product;
}

// Psi_m = (1 - mu^2)^m / 2 * sum over l of w_l (l-m)! / (l+m)! p_l g_l, where the p_l are
// Legendre's functions without their sines and the g_l follow the recurrence of p_l with 2l + 1 -
// w_l for 2l + 1.
std::array<double, 3> three_term_characteristic(const ThreeTermPhase& w, int m) {
  const double h0 = 1 - w[0], h1 = 3 - w[1];
  if (m == 0)
    return {(w[0] + w[2] / 4) / 2, (w[1] * h0 - w[2] * (3 + h1 * h0) / 4) / 2,
            3 * w[2] * h1 * h0 / 8};
  if (m == 1) {
    const double a = w[1] / 4, b = w[2] * h1 / 4;
    return {a, b - a, -b};
  }
  const double a = 3 * w[2] / 16;
  return {a, -2 * a, a};
}

ThreeTermHalfSpace::ThreeTermHalfSpace(ThreeTermPhase w)
    : w_(w), h_{[&] {
        const auto h = [&](int m) {
          const auto psi = three_term_characteristic(w, m);
          return HFunction({psi.begin(), psi.end()}, three_term_k0(w, m));
        };
        return std::array<HFunction, 3>{h(0), h(1), h(2)};
      }()} {
  solve_mode_0();
  solve_mode_1();
}

void ThreeTermHalfSpace::solve_mode_0() {
  if (w_[0] == 0) {
    flux_ = {1, 0};
    return;
  }
  const ModeZero mode(w_, h_[0]);
  const ModeZero::Q q = w_[0] < 0.5 ? mode.solve_by_iteration() : mode.solve_directly();
  mode_0_ = {q.a, q.b, q.c, q.d, q.e, q.f};
  const auto p = mode.polynomials(q);
  flux_ = {p[1][1], p[1][2]};
}

// 4 pi (x + y) f1 = -2 sin sin Q_1 H_1 H_1 with Q_1 = w1/2 q_1 q_1 - 3 w2/2 q_2 q_2, q_1(0) = 1,
// q_2(0) = 0, so Q_1 = w1/2 (1 + l (x + y) + n x y); n from Q_1(x, -x) (1 - x^2) = 2 Psi_1(x), and
// l = the slope of q_1 = w1/4 * integral of (l + n x) (1 - x^2) H_1. What is kept is w1 l and w1 n,
// which are finite at w1 = 0.
void ThreeTermHalfSpace::solve_mode_1() {
  if (w_[1] == 0 && w_[2] == 0) return;
  w1_n_ = -w_[2] * (3 - w_[1]);
  const double m0 = h_[1].moment(0) - h_[1].moment(2), m1 = h_[1].moment(1) - h_[1].moment(3);
  w1_l_ = w_[1] / 4 * w1_n_ * m1 / (1 - w_[1] / 4 * m0);
}

double ThreeTermHalfSpace::mode(int m, double x, double y) const {
  const double s2 = (1 - x) * (1 + x) * (1 - y) * (1 + y);
  const double common = h_[m](x) * h_[m](y) / (4 * kPi * (x + y));
  if (m == 0) {
    const auto& [a, b, c, d, e, f] = mode_0_;
    const double sum = x + y, product = x * y;
    return common * (a + (b + d * product) * sum + (c + e * product) * product +
                     f * (sum * sum - 2 * product));
  }
  if (m == 1) return -common * std::sqrt(s2) * (w_[1] + w1_l_ * (x + y) + w1_n_ * x * y);
  return common * 0.75 * w_[2] * s2;
}

double ThreeTermHalfSpace::operator()(const ReflectionAngles& a) const {
  const double x = a.cos_phi;
  return mode(0, a.mu_i, a.mu_o) + mode(1, a.mu_i, a.mu_o) * x +
         mode(2, a.mu_i, a.mu_o) * (2 * x * x - 1);
}

double ThreeTermHalfSpace::albedo(double mu) const {
  return std::max(0.0, 1 - (flux_[0] + flux_[1] * mu) * h_[0](mu));
}

double three_term_fourier(const ThreeTermPhase& w, int m, double x, double y) {
  const double s2 = (1 - x) * (1 + x) * (1 - y) * (1 + y);
  if (m == 0) return three_term_mean(w[0], w[1], w[2], x * y, legendre_2(x) * legendre_2(y));
  if (m == 1) return std::sqrt(s2) * three_term_slope(w[1], w[2], x * y);
  return 0.75 * w[2] * s2 / (4 * kPi);
}

double three_term_single(const ThreeTermPhase& w, int m, double x, double y) {
  return (m == 1 ? -1 : 1) * three_term_fourier(w, m, x, -y) / (x + y);
}

double three_term_single(const ThreeTermPhase& w, const ReflectionAngles& a) {
  const double cosine = -(a.mu_i * a.mu_o + a.sines_cos);
  return (w[0] + w[1] * cosine + w[2] * legendre_2(cosine)) / (4 * kPi * (a.mu_i + a.mu_o));
}

}  // namespace lamella
