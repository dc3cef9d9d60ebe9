#include "volume/kernel/azimuthal_kernel.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/volume/solver/deterministic_stacks.h"
#include "volume/kernel/layer_scattering.h"
#include "volume/quadrature/quadrature.h"

namespace lamella {
namespace {

TEST(Quadrature, GaussLegendreIntegratesPolynomialsExactly) {
  for (const int n : {1, 2, 7, 32, 97}) {
    const Quadrature rule = gauss_legendre(n);
    for (const int power : {0, 1, n, 2 * n - 1})
      EXPECT_NEAR(rule.weights.dot(rule.points.array().pow(power).matrix()), 1.0 / (power + 1),
                  2e-15)
          << n << ' ' << power;
  }
}

TEST(Quadrature, GrazingMapsReachFromGrazingToTheNormal) {
  for (const GrazingMap& map : {GrazingMap(), GrazingMap(0.15), GrazingMap(0.5)}) {
    EXPECT_EQ(map.mu(0), 0);
    EXPECT_NEAR(map.mu(1), 1, 1e-15);
    for (const double u : {1e-4, 0.0074, 0.0076, 0.1, 0.5, 0.99}) {
      EXPECT_NEAR(map.parameter(map.mu(u)) / u, 1, 1e-13) << u;
      const double h = 1e-5 * u;
      // The difference quotient's own error: 1e-10 of the curvature, rounding over h.
      EXPECT_NEAR((map.mu(u + h) - map.mu(u - h)) / (2 * h * map.slope(u)), 1, 1e-9) << u;
    }
    // The mean of mu log mu, as radiance behaves at grazing.
    const Quadrature rule = grazing_quadrature(48, map);
    EXPECT_NEAR(rule.weights.dot((rule.points.array() * rule.points.array().log()).matrix()), -0.25,
                1e-10);
  }
}

// Directions that are asked for carry the kernel itself, so that its series must give back sigma p.
TEST(AzimuthalKernel, SeriesOfModesGivesBackThePhaseFunction) {
  const int modes = 400;
  const std::vector<double> out{0.3, 0.85}, in{0.55, 1};
  const DirectionSets sets(4, out, in);
  for (const std::string& text :
       {kSphere, henyey_greenstein(0.8), henyey_greenstein(-0.6), sggx(0.3, "mirror"),
        fiber(0.2, "mirror"), vmf(0.3, "mirror"), sggx(0.2, "lambert"), fiber(0.3, "lambert"),
        vmf(0.3, "lambert"), vmf(0.01, "lambert"), vmf(1, "lambert")}) {
    const Medium medium = stack_of(layer(text, 1, 1)).layers[0].medium;
    const KernelModes kernel = kernel_modes(medium, 1, sets, modes);
    for (int part = 0; part < 4; ++part)
      for (int i = 0; i < 2; ++i)
        for (int o = 0; o < 2; ++o)
          for (const double x : {0.2, 1.5, kPi}) {
            const bool above = part == kAboveToUp || part == kAboveToDown;
            const bool up = part == kAboveToUp || part == kBelowToUp;
            const Direction wi = direction_from_mu_phi(above ? in[i] : -in[i], 0);
            const Direction wo = direction_from_mu_phi(up ? out[o] : -out[o], kPi - x);
            double sum = 0;
            for (int m = 0; m < modes; ++m)
              sum += (m == 0 ? 1 : 2) * kernel.modes[m][part](4 + o, 4 + i) * std::cos(m * x);
            const double area = sigma(medium, wi);
            const double expected = area > 1e-12 ? area * phase(medium, wi, wo).density : 0;
            EXPECT_NEAR(sum, expected, 2e-8 * expected + 2e-9)
                << text << ' ' << part << ' ' << in[i] << ' ' << out[o] << ' ' << x;
          }
  }
}

TEST(AzimuthalKernel, RowsOfTheKernelSumToSigma) {
  // What conservation of energy has left to correct is the quadrature's own error.
  const DirectionSets sets(32, {}, {});
  for (const std::string& text :
       {kSphere, henyey_greenstein(0.7), sggx(0.5, "mirror"), vmf(0.4, "mirror"),
        sggx(0.3, "lambert"), vmf(0.3, "lambert"), fiber(0.4, "lambert")}) {
    const Medium medium = stack_of(layer(text, 1, 1)).layers[0].medium;
    EXPECT_LT(LayerScattering(medium, 1, 1, sets, 1).correction, 2e-5) << text;
  }
}

TEST(AzimuthalKernel, SchlickFactorTakesTheHalfAngle) {
  const DirectionSets sets(4, {0.3}, {0.6});
  const Medium medium = stack_of(layer(sggx(0.6, "mirror"), 1, 1)).layers[0].medium;
  const KernelModes kernel = kernel_modes(medium, 0.04, sets, 200);
  const Direction wi = direction_from_mu_phi(0.6, 0), wo = direction_from_mu_phi(0.3, 1.1);
  double sum = 0;
  for (int m = 0; m < 200; ++m)
    sum += (m == 0 ? 1 : 2) * kernel.modes[m][kAboveToUp](4, 4) * std::cos(m * (kPi - 1.1));
  const PhaseValue p = phase(medium, wi, wo);
  EXPECT_NEAR(sum / (sigma(medium, wi) * p.density * (0.04 + 0.96 * p.schlick)), 1, 1e-10);
}

}  // namespace
}  // namespace lamella
