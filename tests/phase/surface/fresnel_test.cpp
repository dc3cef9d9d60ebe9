#include "phase/surface/fresnel.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <boost/multiprecision/cpp_complex.hpp>
#include <cmath>

#include "phase/surface/fresnel_formulas.h"

namespace lamella::testing {
namespace {

using Exact = boost::multiprecision::cpp_complex_50;

// Fresnel's equations with complex numbers of 50 digits.
double exact_reflectance(double cosine, double eta, double k) {
  const Exact n(eta, k), c(cosine);
  const Exact through = sqrt(n * n - 1 + c * c);
  const Exact s = (c - through) / (c + through);
  const Exact p = (n * n * c - through) / (n * n * c + through);
  return static_cast<double>((norm(s) + norm(p)).real() / 2);
}

const double kCosines[] = {0, 1e-150, 1e-9, 1e-4, 0.01, 0.2, 0.5, 0.7, 0.9, 0.999, 1};

TEST(Fresnel, DielectricAgainstFiftyDigits) {
  for (const double n : {1.0001, 1.3, 1.5, 3.0, 1 / 1.0001, 1 / 1.5, 0.2})
    for (const double c : kCosines) {
      // At the critical angle the reflectance has an infinite slope.
      if (n < 1 && std::abs(c * c - (1 - n * n)) < 1e-9) continue;
      EXPECT_NEAR(refraction(c, n).reflectance, exact_reflectance(c, n, 0), 2e-14) << n << ' ' << c;
    }
}

TEST(Fresnel, ConductorAgainstFiftyDigits) {
  for (const double eta : {1e-3, 0.2, 1.0, 1.5, 10.0})
    for (const double k : {0.0, 1e-3, 1.0, 3.9, 20.0})
      for (const double c : kCosines) {
        if (k == 0 && eta == 1) continue;  // no boundary: 0 / 0 at grazing
        if (k == 0 && eta < 1 && std::abs(c * c - (1 - eta * eta)) < 1e-9) continue;
        // 1 - c^2 is rounded, and stands beside eta^2.
        EXPECT_NEAR(conductor_reflectance(c, eta, k), exact_reflectance(c, eta, k),
                    2e-14 + 4e-19 / (eta * eta))
            << eta << ' ' << k << ' ' << c;
      }
}

TEST(Fresnel, KnownValues) {
  EXPECT_NEAR(fresnel_reflectance(1, 1.5), 0.04, 1e-15);
  EXPECT_NEAR(fresnel_reflectance(0, 1.5), 1, 1e-15);
  // Brewster's angle: parallel light passes whole.
  const double n = 1.5, brewster = std::cos(std::atan(n));
  const double rs = (1 - n * n) / (1 + n * n);
  EXPECT_NEAR(fresnel_reflectance(brewster, n), 0.5 * rs * rs, 1e-15);
  // A relative index: copper's 0.2 + 3.9 i in air and under 1.5.
  EXPECT_NEAR(conductor_reflectance(1.0, 0.2, 3.9), (0.64 + 15.21) / (1.44 + 15.21), 1e-14);
  EXPECT_NEAR(conductor_reflectance(1.0, 0.2 / 1.5, 3.9 / 1.5), (1.69 + 15.21) / (2.89 + 15.21),
              1e-14);
}

// 1 - F_int = (1 - F_ext) / n^2 for diffuse light.
TEST(Fresnel, DiffuseLightFromInsideAndOutside) {
  const double n = 1.5, outside = mean_fresnel_reflectance(n);
  EXPECT_NEAR(outside, 0.0918, 5e-5);
  const double critical = std::sqrt(1 - 1 / (n * n));
  const auto passing = [&](double t) {
    const double mu = critical + t * t;  // a root at the critical angle
    return 2 * mu * (1 - fresnel_reflectance(mu, 1 / n)) * 2 * t;
  };
  const double through = boost::math::quadrature::gauss_kronrod<double, 61>::integrate(
      passing, 0, std::sqrt(1 - critical), 15, 1e-13);
  EXPECT_NEAR(1 - through, 0.5963, 5e-5);
  EXPECT_NEAR(through, (1 - outside) / (n * n), 1e-8);
}

TEST(Fresnel, RefractedRayObeysSnell) {
  for (const double n : {1.0001, 1.5, 1 / 1.5, 3.0})
    for (const double c : {0.8, 0.95, 1.0}) {
      const Direction w = direction_from_mu_phi(c, 0.7);
      const Direction m{0, 0, 1};
      const auto r = refraction(c, n);
      const Direction t = refracted_ray(w, m, c, r.cosine, n);
      EXPECT_NEAR(length(t), 1, 1e-15);
      EXPECT_NEAR(-t.z, r.cosine, 1e-14);
      EXPECT_NEAR(n * t.x, -w.x, 1e-14);
      EXPECT_NEAR(n * t.y, -w.y, 1e-14);
    }
}

}  // namespace
}  // namespace lamella::testing
