#include "phase/medium/lambert_sphere.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>

#include "tests/statistics/statistics.h"

namespace lamella::testing {
namespace {

using boost::math::quadrature::gauss_kronrod;

TEST(LambertSphere, PhaseFunctionMatchesManyDigitsDownToTheSmallestDeflection) {
  using Precise = boost::multiprecision::cpp_bin_float_50;
  const Precise pi = boost::math::constants::pi<Precise>();
  for (double x = 1e-15; x < 2; x *= 1.3) {
    const double cosine = 1 - x;
    const Precise theta = acos(Precise(cosine));
    const Precise p = 2 * (sin(theta) - theta * cos(theta)) / (3 * pi * pi);
    const double expected = static_cast<double>(p);
    EXPECT_NEAR(lambert_sphere_phase(cosine), expected, 1e-12 * expected) << x;
  }
  EXPECT_EQ(lambert_sphere_phase(1.0), 0);
  EXPECT_NEAR(lambert_sphere_phase(-1.0), 2 / (3 * kPi), 1e-15);
}

TEST(LambertSphere, CumulativeDistributionIsTheIntegralOfThePhaseFunction) {
  const auto density = [](double c) { return 2 * kPi * lambert_sphere_phase(c); };
  for (const double c : {-0.999, -0.7, 0.0, 0.3, 0.9, 0.999, 0.99999})
    EXPECT_NEAR(lambert_sphere_cdf(c),
                (gauss_kronrod<double, 31>::integrate(density, -1.0, c, 15, 1e-14)), 1e-13)
        << c;
  EXPECT_EQ(lambert_sphere_cdf(1), 1);
  EXPECT_NEAR(lambert_sphere_cdf(-1), 0, 1e-15);
}

TEST(LambertSphere, InverseReturnsTheQuantileAndTheFitStaysWithinItsError) {
  double fit = 0;
  for (int k = 0; k <= 20000; ++k) {
    const double u = k / 20000.0;
    const double exact = lambert_sphere_cosine_inverse(u);
    ASSERT_LE(std::abs(exact), 1);
    ASSERT_LT(std::abs(lambert_sphere_cdf(exact) - u), 1e-14) << u;
    fit = std::max(fit, std::abs(lambert_sphere_cosine_fit(u) - exact));
  }
  EXPECT_LE(fit, 5.8e-4);
  EXPECT_GE(fit, 5e-4);  // the bound is no better than it has to be
  for (const double u : {1e-300, 1e-12, 1 - 1e-12, 1 - 1e-16}) {
    EXPECT_LE(std::abs(lambert_sphere_cosine_inverse(u)), 1);
    EXPECT_LT(std::abs(lambert_sphere_cdf(lambert_sphere_cosine_inverse(u)) - u), 1e-14);
  }
}

TEST(LambertSphere, ThreeUniformsFollowTheCumulativeDistribution) {
  constexpr int kCells = 100, kSamples = 400000;
  std::vector<double> observed(kCells), expected(kCells, kSamples / double{kCells});
  RandomStream stream(11, 0, StreamPurpose::test);
  for (int n = 0; n < kSamples; ++n) {
    const double u1 = stream.uniform(), u2 = stream.uniform(), u3 = stream.uniform();
    const double c = lambert_sphere_cosine(u1, u2, u3);
    ASSERT_LE(std::abs(c), 1);
    const int cell = static_cast<int>(lambert_sphere_cdf(c) * kCells);
    observed[std::clamp(cell, 0, kCells - 1)] += 1;
  }
  EXPECT_GE(chi_square_p_value(observed, expected), test_level());
}

TEST(LambertSphere, TheDeflectionFromOneNumberIsWithinItsErrorOfTheQuantile) {
  double worst = 0, last = 2;
  for (int k = 1; k <= 100000; ++k) {
    const double u = std::pow(k / 100000.0, 2);
    const auto [sine, cosine] = lambert_sphere_deflection(u);
    EXPECT_NEAR(sine * sine + cosine * cosine, 1, 1e-12);
    ASSERT_LT(cosine, last) << u;  // monotone
    last = cosine;
    worst = std::max(worst, std::abs(lambert_sphere_cdf(std::max(cosine, -1.0)) - (1 - u)));
  }
  EXPECT_LE(worst, 1.4e-6);
  EXPECT_GE(worst, 1e-6);  // the bound is no better than it has to be
}

}  // namespace
}  // namespace lamella::testing
