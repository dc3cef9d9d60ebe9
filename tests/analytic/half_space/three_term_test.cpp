#include "analytic/half_space/three_term.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/tanh_sinh.hpp>

#include "analytic/half_space/lambert_sphere_models.h"
#include "tests/analytic/model/successive_orders.h"

namespace lamella {
namespace {

TEST(ThreeTerm, EqualsTheSumOverScatteringOrders) {
  // The second one has no first Legendre term, but a first mode.
  for (const ThreeTermPhase& w : {lambert_sphere_phase_terms(0.6), ThreeTermPhase{0.6, 0, 0.3}}) {
    const ThreeTermHalfSpace exact(w);
    for (int m = 0; m < 3; ++m) {
      const testing::SuccessiveOrders orders(testing::three_term_kernel(w), m, 45);
      double worst = 0;
      const int n = static_cast<int>(orders.nodes().size());
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
          worst = std::max(
              worst,
              std::abs(orders.sum(i, j) / exact.mode(m, orders.nodes()[i], orders.nodes()[j]) - 1));
      EXPECT_LT(worst, 1e-7) << w[1] << ' ' << m;  // the error of the quadrature with 24 nodes
    }
  }
}

TEST(ThreeTerm, FirstModeIsContinuousWhereTheFirstLegendreTermVanishes) {
  const double at_0 = ThreeTermHalfSpace({0.6, 0, 0.3}).mode(1, 0.4, 0.7);
  EXPECT_NEAR(at_0, 0.01228, 5e-6);
  for (const double w1 : {1e-9, -1e-9})
    EXPECT_NEAR(ThreeTermHalfSpace({0.6, w1, 0.3}).mode(1, 0.4, 0.7), at_0, 1e-10);
}

TEST(ThreeTerm, SolvesTheNonlinearEquationOfInvariance) {
  // (x + y) T = sum over l of e_l w_l (l-m)! / (l+m)! psi_l(x) psi_l(y), with
  // psi_l(x) = P_l^m(x) + e_l x / 2 int T(x, z) P_l^m(z) dz and e_l = (-1)^(l+m).
  boost::math::quadrature::tanh_sinh<double> integrator;
  const auto legendre = [](int l, int m, double x) {
    const double s = std::sqrt((1 - x) * (1 + x));
    if (m == 0) return l == 0 ? 1 : l == 1 ? x : 1.5 * x * x - 0.5;
    if (m == 1) return l == 1 ? s : 3 * x * s;
    return 3 * s * s;
  };
  const double factorials[3][3] = {{1, 1, 1}, {0, 1.0 / 2, 1.0 / 6}, {0, 0, 1.0 / 24}};
  for (const double c : {1e-6, 0.3, 0.499, 0.501, 0.9, 0.999, 1 - 1e-10, 1.0}) {
    const ThreeTermPhase w = lambert_sphere_phase_terms(c);
    const ThreeTermHalfSpace exact(w);
    for (int m = 0; m < 3; ++m) {
      const auto t = [&](double x, double y) {
        return 4 * kPi * (m == 1 ? -0.5 : m == 2 ? 0.5 : 1) * exact.mode(m, x, y);
      };
      const auto psi = [&](int l, double x) {
        const auto f = [&](double z) { return t(x, z) * legendre(l, m, z); };
        return legendre(l, m, x) +
               ((l + m) % 2 ? -1 : 1) * x / 2 * integrator.integrate(f, 0.0, 1.0);
      };
      for (const double x : {1.0, 0.4, 0.05})
        for (const double y : {0.8, 0.2}) {
          if (m > 0 && x == 1) continue;
          double sum = 0;
          for (int l = m; l < 3; ++l)
            sum += ((l + m) % 2 ? -1 : 1) * w[l] * factorials[m][l] * psi(l, x) * psi(l, y);
          const double merge = c < 1 ? std::min(1e-7, 1e-14 / std::sqrt(1 - c)) : 0;
          EXPECT_NEAR(sum / ((x + y) * t(x, y)), 1, 1e-10 + merge) << c << ' ' << m << ' ' << x;
        }
    }
  }
}

TEST(ThreeTerm, AlbedoEqualsTheIntegralOfTheAzimuthalMean) {
  boost::math::quadrature::tanh_sinh<double> integrator;
  for (const double c : {0.2, 0.7, 0.99, 1.0}) {
    const ThreeTermHalfSpace exact(lambert_sphere_phase_terms(c));
    for (const double x : {1.0, 0.3, 1e-3}) {
      const auto f = [&](double y) { return 2 * kPi * y * exact.mode(0, x, y); };
      EXPECT_NEAR(exact.albedo(x), integrator.integrate(f, 0.0, 1.0), 1e-10) << c << ' ' << x;
    }
  }
  EXPECT_NEAR(ThreeTermHalfSpace(lambert_sphere_phase_terms(1)).albedo(0.5), 1, 1e-12);
}

TEST(ThreeTerm, BothSolversAgreeWhereTheyMeet) {
  const ThreeTermHalfSpace below(lambert_sphere_phase_terms(0.5 - 1e-9)),
      above(lambert_sphere_phase_terms(0.5));
  for (int k = 0; k < 6; ++k)
    EXPECT_NEAR(below.mode_0_constants()[k], above.mode_0_constants()[k], 3e-9) << k;
}

TEST(ThreeTerm, IsotropicScatteringIsItsSpecialCase) {
  for (const double c : {0.3, 0.9}) {
    const ThreeTermHalfSpace exact({c, 0, 0});
    const HFunction h = isotropic_h(c);
    EXPECT_NEAR(exact.mode(0, 0.7, 0.2), c / (4 * kPi) * h(0.7) * h(0.2) / 0.9, 1e-12);
    EXPECT_EQ(exact.mode(1, 0.7, 0.2), 0);
    EXPECT_EQ(exact.mode(2, 0.7, 0.2), 0);
  }
}

TEST(ThreeTerm, CharacteristicFunctionsAreThoseOfThePaper) {
  // d'Eon 2021, section 3.1
  const double c = 0.7;
  const ThreeTermPhase w = lambert_sphere_phase_terms(c);
  const auto psi = [&](int m, double x) {
    const auto p = three_term_characteristic(w, m);
    return p[0] + (p[1] + p[2] * x * x) * x * x;
  };
  for (const double x : {0.0, 0.4, 1.0}) {
    const double x2 = x * x, s2 = x2 - 1;
    EXPECT_NEAR(
        psi(0, x),
        c / 384 * (-15 * (c - 1) * (4 * c + 9) * x2 * x2 + (c * (20 * c + 281) - 346) * x2 + 207),
        1e-15);
    EXPECT_NEAR(psi(1, x), -c / 192 * s2 * (5 * (4 * c + 9) * x2 - 64), 1e-15);
    EXPECT_NEAR(psi(2, x), 15 * c / 256 * s2 * s2, 1e-15);
  }
  EXPECT_NEAR(three_term_k0(w, 0), (c - 16) * (c - 1) * (4 * c + 9) / 144, 1e-15);
  for (int m = 0; m < 3; ++m) {
    const auto p = three_term_characteristic(w, m);
    EXPECT_NEAR(three_term_k0(w, m), 1 - 2 * (p[0] + p[1] / 3 + p[2] / 5), 1e-15) << m;
  }
}

}  // namespace
}  // namespace lamella
