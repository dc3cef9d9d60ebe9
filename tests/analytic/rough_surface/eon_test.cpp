#include "analytic/rough_surface/eon.h"

#include <gtest/gtest.h>

#include <boost/math/constants/constants.hpp>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>

#include "tests/analytic/model/model_checks.h"
#include "tests/statistics/statistics.h"

namespace lamella {
namespace {

using boost::math::quadrature::gauss_kronrod;
using testing::make_model;

TEST(Eon, IsReciprocalFiniteAndAddsUp) {
  for (const char* name : {"fon", "eon", "eon_approx"})
    for (const double r : {0.0, 1e-8, 0.3, 1.0}) {
      SCOPED_TRACE(name);
      const auto model = make_model(name, {{"albedo", Rgb(1, 0.6, 0)}, {"roughness", r}});
      testing::expect_sane_values(*model, std::string(name) == "fon" ? 1 : 2);
      testing::expect_reciprocal(*model);
    }
}

TEST(Eon, ZeroRoughnessIsLambert) {
  for (const char* name : {"fon", "eon", "eon_approx"}) {
    const auto model = make_model(name, {{"albedo", 0.7}, {"roughness", 0.0}});
    for (const Direction wo : testing::probe_directions())
      EXPECT_NEAR(model->eval(direction_from_degrees(50, 0), wo).r, 0.7 / kPi, 1e-16) << name;
  }
}

TEST(Eon, AlbedoEqualsQuadrature) {
  for (const char* name : {"fon", "eon", "eon_approx"})
    testing::expect_albedo_equals_quadrature(
        *make_model(name, {{"albedo", Rgb(1, 0.7, 0.2)}, {"roughness", 0.8}}));
}

TEST(Eon, PassesTheWhiteFurnace) {
  double low = 1, high = 1;
  for (const double r : {0.0, 0.1, 0.5, 1.0}) {
    const auto exact = make_model("eon", {{"roughness", r}});
    const auto fit = make_model("eon_approx", {{"roughness", r}});
    for (int k = 0; k <= 1000; ++k) {
      const Direction wi = direction_from_mu_phi(k / 1000.0, 0);
      EXPECT_NEAR(exact->albedo(wi).r, 1, 1e-15);
      low = std::min(low, fit->albedo(wi).r);
      high = std::max(high, fit->albedo(wi).r);
    }
  }
  EXPECT_GT(low, 0.9994);
  EXPECT_LT(high, 1.0002);
}

TEST(Eon, AverageAlbedoIsTheMeanOfTheDirectionalOne) {
  for (const double r : {0.2, 1.0}) {
    const auto f = [&](double mu) { return 2 * mu * fon_albedo(mu, r); };
    EXPECT_NEAR(fon_average_albedo(r),
                (gauss_kronrod<double, 31>::integrate(f, 0.0, 1.0, 12, 1e-13)), 1e-12);
    EXPECT_NEAR(fon_albedo(0, r), 1, 1e-15);
  }
  // Section 2.2 says that FON loses about 20 %: it is 16.7 %.
  EXPECT_NEAR(1 - fon_average_albedo(1), 0.167, 5e-4);
}

TEST(Eon, FittedAlbedoKeepsItsStatedError) {
  double worst = 0, excess = 0;
  for (const double r : {0.01, 0.3, 1.0})
    for (int k = 0; k <= 1000; ++k) {
      const double mu = k / 1000.0;
      worst = std::max(worst, std::abs(fon_albedo_fit(mu, r) - fon_albedo(mu, r)) / r);
      excess = std::max(excess, fon_albedo_fit(mu, r) - 1);
    }
  EXPECT_LT(worst, 6.1e-4);
  EXPECT_LT(excess, 3.7e-4);
}

TEST(Eon, MultipleScatteringIsTheSeriesFromTwoBounces) {
  // Eq. 18: its first line also has the 1-bounce term rho <E>, with which F would be 0.66.
  const double rho = 0.7, e = fon_average_albedo(1);
  double series = 0;
  for (int bounces = 2; bounces < 200; ++bounces)
    series += std::pow(rho, bounces) * std::pow(1 - e, bounces - 1) * e;
  EXPECT_NEAR(series, 0.0772691, 5e-8);
  EXPECT_NEAR(rho * e + series, 0.66024, 5e-6);
  // F is the average albedo of the lobe ms.
  const auto eon = make_model("eon", {{"albedo", rho}, {"roughness", 1.0}});
  const auto f = [&](double mu) {
    return 2 * mu * (eon->albedo(direction_from_mu_phi(mu, 0)).r - rho * fon_albedo(mu, 1));
  };
  EXPECT_NEAR((gauss_kronrod<double, 31>::integrate(f, 0.0, 1.0, 12, 1e-13)), series, 1e-12);
}

TEST(Eon, MultipleScatteringIsTintedByTheSquareOfTheAlbedo) {
  const auto model = make_model("eon", {{"albedo", Rgb(1, 0.1, 1e-3)}, {"roughness", 1.0}});
  const Direction w = direction_from_degrees(30, 0);
  const Rgb ms = model->eval_lobe(1, w, w);
  EXPECT_NEAR(
      ms.b / ms.g,
      1e-4 * (1 - 0.1 * (1 - fon_average_albedo(1))) / (1 - 1e-3 * (1 - fon_average_albedo(1))),
      1e-12);
}

TEST(Eon, LossKeepsAllDigitsDownToGrazing) {
  // The printed form, G_F by eqs. 8 and 13, in 100 digits.
  using Long = boost::multiprecision::cpp_bin_float_100;
  const auto printed = [](double x) {
    const Long mu = x, s = sqrt(1 - mu * mu), pi = boost::math::constants::pi<Long>();
    const Long third = Long(2) / 3;
    const Long g = s * (acos(mu) - s * mu) + third * (s / mu * (1 - s * s * s) - s);
    return Long(0.5) - third / pi - g / pi;
  };
  double worst = 0, worst_float = 0, worst_albedo = 0;
  const auto check = [&](double mu) {
    const Long exact = printed(mu);
    worst = std::max(worst, std::abs(static_cast<double>(fon_loss(mu) / exact - 1)));
    const Long albedo = 1 - exact / (1 + Long(kFonNormalLoss));  // r = 1
    worst_albedo =
        std::max(worst_albedo, std::abs(static_cast<double>(fon_albedo(mu, 1) - albedo)));
    const auto single = static_cast<float>(mu);
    worst_float = std::max(worst_float,
                           std::abs(static_cast<double>(fon_loss(single) / printed(single) - 1)));
  };
  for (double mu = 1; mu > 1e-20; mu *= 0.97) check(mu);
  for (int k = 1; k <= 1000; ++k) check(k / 1000.0);
  EXPECT_LT(worst, 5 * std::numeric_limits<double>::epsilon());
  EXPECT_LT(worst_float, 5 * std::numeric_limits<float>::epsilon());
  EXPECT_LT(worst_albedo, 3e-16);
  EXPECT_EQ(fon_loss(0.0), 0);
  EXPECT_EQ(fon_loss(0.0f), 0);
}

TEST(Eon, SamplersFollowTheirPdf) {
  for (const double r : {0.0, 0.4})
    testing::expect_sampler_follows_its_pdf("eon", *make_model("eon", {{"roughness", r}}), 1e-6);
  for (const char* sampler : {"mis", "cltc", "ltc", "cosine", "uniform"})
    testing::expect_sampler_follows_its_pdf(
        sampler, *make_model("eon", {{"roughness", 1.0}, {"sampler", std::string(sampler)}}), 1e-6);
}

TEST(Eon, SamplerKeepsTheThroughputBounded) {
  // f mu / pdf down to grazing w_o, where the cosine law has no bound.
  double worst = 0, worst_cosine = 0;
  const auto eon = make_model("eon", {{"roughness", 1.0}});
  for (const double mu_o : {0.01, 0.1, 0.5, 1.0})
    for (double mu = 0.005; mu < 1; mu += 0.01)
      for (double phi = 0; phi < 3.2; phi += 0.2) {
        const Direction wi = direction_from_mu_phi(mu, phi), wo = direction_from_mu_phi(mu_o, 0);
        const double f = eon->eval(wi, wo).r;
        worst = std::max(worst, f * mu / eon->pdf(wi, wo));
        worst_cosine = std::max(worst_cosine, f * kPi);
      }
  EXPECT_LT(worst, 1.5);
  EXPECT_GT(worst_cosine, 70);
}

}  // namespace
}  // namespace lamella
