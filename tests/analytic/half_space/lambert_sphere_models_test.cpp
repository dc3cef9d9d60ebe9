#include "analytic/half_space/lambert_sphere_models.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/math/special_functions/legendre.hpp>

#include "phase/medium/lambert_sphere.h"
#include "phase/stack/stack_file.h"
#include "tests/analytic/model/model_checks.h"
#include "tests/analytic/model/nested_quadrature.h"
#include "tests/analytic/model/successive_orders.h"

namespace lamella {
namespace {

using boost::math::quadrature::gauss_kronrod;
using testing::make_model;

const char* const kSphereNames[] = {"lambert_sphere", "lambert_sphere_fast", "hapke_lambert_sphere",
                                    "lambert_sphere_three_term", "lambert_sphere_three_term_pure"};

struct Deviation {
  double worst_relative = 0, worst = 0, rms = 0;
};

/// Of a form from the exact three-term one over albedos and directions.
Deviation deviation(const std::string& name) {
  Deviation d;
  int n = 0;
  for (const double c : {0.3, 0.9, 1.0}) {
    const auto exact = make_model("lambert_sphere_three_term", {{"albedo", c}});
    const auto model = make_model(name, {{"albedo", c}});
    for (const double mi : {0.05, 0.2, 0.5, 0.8, 1.0})
      for (const double mo : {0.05, 0.2, 0.5, 0.8, 1.0})
        for (const double phi : {0.0, 1.57, 3.14159}) {
          const Direction wi = direction_from_mu_phi(mi, 0), wo = direction_from_mu_phi(mo, phi);
          const double truth = exact->eval(wi, wo).r;
          const double error = model->eval(wi, wo).r - truth;
          d.worst = std::max(d.worst, std::abs(error));
          d.worst_relative = std::max(d.worst_relative, std::abs(error) / truth);
          d.rms += error * error;
          ++n;
        }
  }
  d.rms = std::sqrt(d.rms / n);
  return d;
}

TEST(LambertSphereBrdf, IsReciprocalFiniteAndAddsUp) {
  for (const char* name : kSphereNames) {
    SCOPED_TRACE(name);
    const auto model = make_model(name, {{"albedo", Rgb(1, 0.5, 0.1)}});
    testing::expect_sane_values(*model, 2, true);
    testing::expect_reciprocal(*model);
  }
}

TEST(LambertSphereBrdf, FormsKeepTheirStatedErrors) {
  const Deviation analytic = deviation("lambert_sphere");
  const Deviation fast = deviation("lambert_sphere_fast");
  const Deviation hapke = deviation("hapke_lambert_sphere");
  const Deviation pure = deviation("lambert_sphere_three_term_pure");
  EXPECT_LT(analytic.worst_relative, 0.073);
  EXPECT_LT(analytic.rms, 0.0041);
  EXPECT_LT(fast.worst, 0.11);
  EXPECT_LT(fast.rms, 0.033);
  EXPECT_LT(hapke.worst, 0.17);
  EXPECT_LT(hapke.rms, 0.030);
  EXPECT_NEAR(pure.worst_relative, 0.215, 0.005);
}

TEST(LambertSphereBrdf, PrintedFirstModeIsHalfOfTheExactOne) {
  // Eq. 27 with exact H1, l and n; then eq. 34 against the integral that eq. 33 prints.
  for (const double c : {0.3, 0.9, 1.0}) {
    const ThreeTermHalfSpace exact(lambert_sphere_phase_terms(c));
    for (const double x : {0.1, 0.6})
      for (const double y : {0.3, 0.9}) {
        const double s = std::sqrt((1 - x * x) * (1 - y * y));
        const double printed = c * exact.h(1)(x) * exact.h(1)(y) / (6 * kPi * (x + y)) * s *
                               (1 + exact.n() * x * y + exact.l() * (x + y));
        EXPECT_NEAR(exact.mode(1, x, y) / printed, 2, 1e-12);
        const double eq_34 = c * (45 * x * y + 64) * s / (384 * kPi * (x + y));
        EXPECT_NEAR(three_term_single(lambert_sphere_phase_terms(c), 1, x, y) / eq_34, 2, 1e-12);
        const double eq_44 = c * (207 + 135 * x * x * y * y - 45 * (x * x + y * y) + 256 * x * y) /
                             (768 * kPi * (x + y));
        EXPECT_NEAR(three_term_single(lambert_sphere_phase_terms(c), 0, x, y), eq_44, 1e-15);
      }
  }
}

TEST(LambertSphereBrdf, FittedConstantsAgreeWithTheExactOnes) {
  for (const double c : {0.1, 0.5, 0.9, 1.0}) {
    const ThreeTermHalfSpace exact(lambert_sphere_phase_terms(c));
    EXPECT_NEAR((-0.00473696 * c - 0.0589037) * c, exact.l(), 2e-4) << c;
    // l^2 + 45 m / 64 of eq. 27 is 5 (4 c + 9) / 64, by Q(x, -x) = 2 Psi_1
    const double l = exact.l();
    EXPECT_NEAR(exact.n(), 5 * (4 * c + 9) / 64, 1e-14);
    EXPECT_NEAR(l * l + 45 * (0.44038 * c + 1) / 64, exact.n(), 2e-3) << c;
    EXPECT_NEAR(exact.mode_0_constants()[0] / 2, 69 * c / 128, 1e-15);
    EXPECT_NEAR(exact.mode_0_constants()[4] / 2, 15.0 / 128 * (1 - c) * c * (4 * c / 3 + 3), 1e-15);
  }
}

TEST(LambertSphereBrdf, FittedHFunctionsKeepTheirStatedErrors) {
  double h0 = 0, h1 = 0, printed = 0;
  for (const double c : {0.05, 0.3, 0.6, 0.9, 0.99, 1.0}) {
    const ThreeTermHalfSpace exact(lambert_sphere_phase_terms(c));
    for (int k = 0; k <= 100; ++k) {
      const double mu = k / 100.0;
      h0 = std::max(h0, std::abs(lambert_sphere_h0(mu, c) / exact.h(0)(mu) - 1));
      h1 = std::max(h1, std::abs(lambert_sphere_h1(mu, c) / exact.h(1)(mu) - 1));
      // eqs. 28-30 as printed: H1(1) times the values at c = 1
      const double e = ((-1.12831 * mu + 1.85728) * mu - 1.07879) * mu + 0.459442;
      const double product =
          std::exp((0.0242851 * c - 0.144839) * c) * std::exp(-0.0894878 * std::pow(mu, e));
      printed = std::max(printed, std::abs(product / exact.h(1)(mu) - 1));
    }
  }
  EXPECT_LT(h0, 0.0082);
  EXPECT_LT(h1, 0.0031);
  EXPECT_GT(printed, 0.10);
}

TEST(LambertSphereBrdf, LegendreCoefficientsAreThoseOfThePhaseFunction) {
  for (int k = 0; k <= 12; ++k) {
    const auto f = [&](double x) {
      return 2 * kPi * (2 * k + 1) * lambert_sphere_phase(x) * boost::math::legendre_p(k, x);
    };
    EXPECT_NEAR(lambert_sphere_legendre(k), (gauss_kronrod<double, 31>::integrate(f, -1, 1, 12)),
                1e-8)
        << k;
  }
  // Eq. 4
  EXPECT_EQ(lambert_sphere_legendre(2), 5.0 / 16);
  EXPECT_NEAR(lambert_sphere_legendre(4), 1.0 / 64, 1e-17);
}

TEST(LambertSphereBrdf, FourierComponentsAreThoseOfTheTruncatedPhaseFunction) {
  const ThreeTermPhase w = lambert_sphere_phase_terms(1);
  for (const double x : {0.9, -0.2})
    for (const double y : {0.5, 0.1}) {
      const double s = std::sqrt((1 - x * x) * (1 - y * y));
      for (int m = 0; m < 3; ++m) {
        const auto f = [&](double phi) {
          const double mu = x * y + s * std::cos(phi);  // eq. 9
          return (27.0 / 32 - 4 * mu / 3 + 15 * mu * mu / 32) / (4 * kPi) * std::cos(m * phi);
        };
        const double integral = gauss_kronrod<double, 31>::integrate(f, 0.0, kPi, 5);  // eq. 8
        EXPECT_NEAR(three_term_fourier(w, m, x, y), (m == 0 ? 1 : 2) / kPi * integral, 1e-14);
      }
      EXPECT_NEAR(three_term_fourier(w, 0, x, y),  // eqs. 10-12
                  (45 * x * x * (3 * y * y - 1) - 256 * x * y - 45 * y * y + 207) / (768 * kPi),
                  1e-15);
      EXPECT_NEAR(three_term_fourier(w, 1, x, y), (45 * x * y - 64) * s / (192 * kPi), 1e-15);
      EXPECT_NEAR(three_term_fourier(w, 2, x, y), 15 * s * s / (256 * kPi), 1e-15);
    }
}

TEST(LambertSphereBrdf, AlbedoMapsKeepTheirStatedErrors) {
  double map = 0, inverse = 0;
  for (const double c : {0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97, 1.0}) {
    const ThreeTermHalfSpace exact(lambert_sphere_phase_terms(c));
    const auto f = [&](double mu) { return 2 * mu * exact.albedo(mu); };
    const double bond = gauss_kronrod<double, 31>::integrate(f, 0.0, 1.0, 8);
    map = std::max(map, std::abs(lambert_sphere_bond_albedo(c) - bond));
    inverse = std::max(inverse, std::abs(lambert_sphere_albedo(bond) - c));
  }
  EXPECT_LT(map, 0.0020);
  EXPECT_LT(inverse, 0.0063);
}

TEST(LambertSphereBrdf, ThreeTermFormIsWithinItsStatedErrorOfTheSphere) {
  // Against the sum over scattering orders with the sphere's own phase function, four modes.
  const double c = 0.7;
  std::vector<testing::SuccessiveOrders> modes;
  for (int m = 0; m < 4; ++m) modes.emplace_back(testing::lambert_sphere_kernel(c), m, 40);
  const auto model = make_model("lambert_sphere_three_term", {{"albedo", c}});
  const auto& nodes = modes[0].nodes();
  double worst = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (std::size_t j = 0; j < nodes.size(); ++j)
      for (const double phi : {0.0, 1.0, 2.0, kPi}) {
        if (nodes[i] < 0.01 || nodes[j] < 0.01) continue;
        const Direction wi = direction_from_mu_phi(nodes[i], 0);
        const Direction wo = direction_from_mu_phi(nodes[j], phi);
        double truth = c * lambert_sphere_single(*reflection_angles(wi, wo));
        for (int m = 0; m < 4; ++m) truth += modes[m].sum(i, j, 2) * std::cos(m * phi);
        worst = std::max(worst, std::abs(model->eval(wi, wo).r / truth - 1));
      }
  EXPECT_LT(worst, 0.002);
}

TEST(LambertSphereBrdf, AlbedoOfTheThreeTermFormsEqualsQuadrature) {
  for (const char* name : {"lambert_sphere_three_term", "lambert_sphere_three_term_pure"}) {
    const auto model = make_model(name, {{"albedo", 0.9}});
    for (const double mu : {1.0, 0.3}) {
      const Direction wi = direction_from_mu_phi(mu, 0);
      const auto f = [&](Direction wo) { return model->eval(wi, wo).r; };
      EXPECT_NEAR(model->albedo(wi).r, integrate_projected(f, 1, 1e-8), 1e-8) << name << mu;
    }
  }
}

TEST(LambertSphereBrdf, WhiteHalfSpaceOfTheThreeTermFormKeepsItsEnergy) {
  const auto pure = make_model("lambert_sphere_three_term_pure", {});
  const auto model = make_model("lambert_sphere_three_term", {});
  double worst = 0;
  for (const double mu : {1.0, 0.6, 0.2, 0.05, 1e-7}) {
    const Direction wi = direction_from_mu_phi(mu, 0);
    EXPECT_NEAR(pure->albedo(wi).r, 1, 1e-12);
    worst = std::max(worst, std::abs(model->albedo(wi).r - 1));
  }
  EXPECT_LT(worst, 1.2e-4);
}

TEST(LambertSphereBrdf, SamplersFollowTheirPdf) {
  testing::expect_sampler_follows_its_pdf("lambert_sphere", *make_model("lambert_sphere", {}));
}

TEST(LambertSphereBrdf, AppliesToItsHalfSpaceOnly) {
  const std::string sphere = "[[layer]]\nmedium = \"lambert_sphere\"\nalbedo = 0.8\n";
  for (const char* name : kSphereNames) {
    const ModelInfo& info = *find_model(name);
    const auto p = info.applies_to(parse_stack(sphere + "thickness = inf\n", "", ""));
    ASSERT_TRUE(p) << name;
    EXPECT_EQ(p->color("albedo"), Rgb(0.8));
    EXPECT_FALSE(info.applies_to(parse_stack(sphere + "thickness = 1\n", "", ""))) << name;
  }
}

}  // namespace
}  // namespace lamella
