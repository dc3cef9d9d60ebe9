#include "analytic/rough_surface/oren_nayar.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss_kronrod.hpp>

#include "tests/analytic/model/model_checks.h"
#include "tests/analytic/model/nested_quadrature.h"

namespace lamella {
namespace {

using boost::math::quadrature::gauss_kronrod;
using testing::make_model;

const char* const kOrenNayarNames[] = {"oren_nayar_full", "oren_nayar", "oren_nayar_footnote",
                                       "fujii_qualitative"};

double term_integral(double mu, double (*term)(const ReflectionAngles&)) {
  const Direction wo = direction_from_mu_phi(mu, 0);
  return integrate_projected([&](Direction wi) { return term(*reflection_angles(wi, wo)); }, 1,
                             1e-10);
}

TEST(OrenNayar, IsReciprocalFiniteAndAddsUp) {
  for (const char* name : kOrenNayarNames)
    for (const double sigma : {0.0, 0.2, 0.8, kPi / 2}) {
      SCOPED_TRACE(name);
      const auto model = make_model(name, {{"albedo", Rgb(1, 0.6, 0)}, {"sigma", sigma}});
      // The full model is negative in some forward pairs near grazing.
      const bool full = std::string(name) == "oren_nayar_full";
      testing::expect_sane_values(*model, full ? 2 : 1, full);
      testing::expect_reciprocal(*model);
    }
}

TEST(OrenNayar, ZeroRoughnessIsLambert) {
  for (const char* name : kOrenNayarNames) {
    const auto model = make_model(name, {{"albedo", 0.7}, {"sigma", 0.0}});
    for (const Direction wo : testing::probe_directions())
      EXPECT_NEAR(model->eval(direction_from_degrees(50, 0), wo).r, 0.7 / kPi, 1e-16) << name;
  }
}

TEST(OrenNayar, IntegralsAreThoseOfTheTerms) {
  for (const double mu : {1.0, 0.7, 0.2, 1e-2}) {
    EXPECT_NEAR(oren_nayar_integral(mu), term_integral(mu, oren_nayar_term), 1e-8) << mu;
    EXPECT_NEAR(fujii_integral(mu), term_integral(mu, fujii_term), 1e-8) << mu;
    // eq. 8 as printed, where it does not divide by zero
    const double theta = std::acos(mu), s = std::sin(theta);
    EXPECT_NEAR(oren_nayar_integral(mu), s * (theta - s * mu) + 2.0 / 3 * s / mu * (1 - s * s * s),
                1e-13);
  }
  EXPECT_NEAR(oren_nayar_integral(0), kPi / 2, 1e-15);
  EXPECT_NEAR(oren_nayar_integral(1e-7), kPi / 2, 1e-6);
}

TEST(OrenNayar, MeansAreThoseOfTheIntegrals) {
  const auto mean = [](double (*g)(double)) {
    const auto f = [&](double theta) {  // smooth, unlike the integrand in mu
      return std::sin(2 * theta) * g(std::cos(theta)) / kPi;
    };
    return gauss_kronrod<double, 31>::integrate(f, 0.0, kPi / 2, 12, 1e-13);
  };
  EXPECT_NEAR(mean(oren_nayar_integral), kOrenNayarMean, 1e-12);
  EXPECT_NEAR(mean(fujii_integral), kFujiiMean, 1e-12);
}

TEST(OrenNayar, AlbedoEqualsQuadrature) {
  for (const char* name : {"oren_nayar", "oren_nayar_footnote", "fujii_qualitative"})
    testing::expect_albedo_equals_quadrature(
        *make_model(name, {{"albedo", Rgb(1, 0.7, 0.2)}, {"sigma", 0.8}}));
}

TEST(OrenNayar, QualitativeModelGainsEnergyForSmallSigmaOnly) {
  // EON's section 2.1 says "for high sigma"; at grazing E = A + B / 2, which exceeds 1 for
  // sigma < 0.3261 = sqrt(0.02925 / 0.275), is 1.0152 at 0.198 and 0.776 at pi / 2.
  const auto grazing = [](double sigma) {
    return make_model("oren_nayar", {{"sigma", sigma}})->albedo({1, 0, 0}).r;
  };
  EXPECT_NEAR(grazing(0.198), 1.0152, 5e-5);
  EXPECT_GT(grazing(0.326), 1);
  EXPECT_LT(grazing(0.3262), 1);
  EXPECT_NEAR(grazing(kPi / 2), 0.776, 5e-4);
}

TEST(OrenNayar, FullModelAgreesWithItsDefinitionInAngles) {
  const double sigma = 0.6, rho = 0.8, ti = 0.4, to = 1.1, phi = 2.2;
  const auto model = make_model("oren_nayar_full", {{"albedo", rho}, {"sigma", sigma}});
  const double s2 = sigma * sigma, x = std::cos(phi), b = 2 * ti / kPi;
  const double c = s2 / (s2 + 0.09);
  const double single = 1 - 0.5 * s2 / (s2 + 0.33) +
                        x * 0.45 * c * (std::sin(to) - b * b * b) * std::tan(ti) +
                        (1 - std::abs(x)) * 0.125 * c * std::pow(4 * to * ti / (kPi * kPi), 2) *
                            std::tan((ti + to) / 2);
  const double twice = 0.17 * s2 / (s2 + 0.13) * (1 - x * b * b);
  const Direction wi = direction_from_mu_phi(std::cos(ti), 0.3),
                  wo = direction_from_mu_phi(std::cos(to), 0.3 + phi);
  EXPECT_NEAR(model->eval_lobe(0, wi, wo).r, rho / kPi * single, 1e-15);
  EXPECT_NEAR(model->eval_lobe(1, wi, wo).r, rho * rho / kPi * twice, 1e-15);
}

TEST(OrenNayar, SamplersFollowTheirPdf) {
  testing::expect_sampler_follows_its_pdf("oren_nayar", *make_model("oren_nayar", {}));
}

}  // namespace
}  // namespace lamella
