#include "analytic/facets/sheen_conty_kulla.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>

#include "tests/analytic/model/model_checks.h"

namespace lamella {
namespace {

using boost::math::quadrature::gauss_kronrod;

// mu (1 + Lambda) by quadrature: the area that facets of density D show.
double shown(double mu, double roughness) {
  const double s = std::sqrt((1 - mu) * (1 + mu));
  return gauss_kronrod<double, 31>::integrate(
      [&](double theta) {
        const double a = mu * std::cos(theta), b = s * std::sin(theta);
        // The positive part of a + b cos(phi), integrated over phi.
        const double end = a >= b ? kPi : std::acos(-a / b);
        return sheen_density(std::sin(theta), roughness) * std::sin(theta) * 2 *
               (a * end + b * std::sin(end));
      },
      0.0, kPi / 2, 12, 1e-9);
}

TEST(Sheen, ItsDensityIsNormalised) {
  for (const double r : {0.05, 0.3, 1.0})
    EXPECT_NEAR((gauss_kronrod<double, 31>::integrate(
                    [&](double theta) {
                      return 2 * kPi * sheen_density(std::sin(theta), r) * std::sin(theta) *
                             std::cos(theta);
                    },
                    0.0, kPi / 2, 10, 1e-10)),
                1, 1e-8);
}

// The paper's fit against the exact Smith term of its D.
TEST(Sheen, TheMaskingIsThatOfTheDensity) {
  double worst = 0;
  for (const double r : {0.1, 0.25, 0.5, 0.75, 1.0})
    for (const double mu : {0.95, 0.7, 0.5, 0.3, 0.1, 0.03, 0.01}) {
      const double exact = shown(mu, r), fit = mu + sheen_masking(mu, r);
      worst = std::max(worst, std::abs(fit / exact - 1));
      EXPECT_NEAR(fit / exact, 1, 0.25) << r << ' ' << mu;
    }
  std::printf("worst %g\n", worst);
}

TEST(Sheen, IsReciprocalFiniteAndLosesEnergy) {
  for (const double r : {0.1, 0.2, 0.5, 1.0}) {
    const auto model = testing::make_model("sheen_conty_kulla", {{"roughness", r}});
    testing::expect_sane_values(*model, 1);
    testing::expect_reciprocal(*model);
    for (const double mu : {1.0, 0.5, 0.1, 1e-3, 1e-6, 0.0})
      EXPECT_LT(model->albedo(with_grazing_limit(direction_from_mu_phi(mu, 0))).g, 1)
          << r << ' ' << mu;
  }
}

TEST(Sheen, SamplesFollowTheirDensity) {
  testing::expect_sampler_follows_its_pdf("sheen", *testing::make_model("sheen_conty_kulla", {}),
                                          1e-6);
}

}  // namespace
}  // namespace lamella
