#include <gtest/gtest.h>

#include <boost/math/quadrature/tanh_sinh.hpp>

#include "analytic/half_space/h_function.h"
#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"
#include "tests/analytic/model/model_checks.h"

namespace lamella {
namespace {

using testing::make_model;

const double kAlbedos[] = {0, 0.1, 0.5, 0.9, 0.99, 0.9999, 1 - 1e-9, 1};

TEST(HFunction, IsotropicConservativeValueAtNormalIncidence) {
  // Chandrasekhar 1960, table XI: H(1) = 2.907810529 at albedo 1.
  EXPECT_NEAR(isotropic_h(1)(1), 2.907810529, 5e-10);
  EXPECT_NEAR(isotropic_h(1).by_quadrature(1), 2.907810529, 5e-10);
}

TEST(HFunction, SolvesItsIntegralEquation) {
  boost::math::quadrature::tanh_sinh<double> integrator;
  for (const double c : kAlbedos) {
    const HFunction h = isotropic_h(c);
    for (const double mu : {1.0, 0.5, 0.1, 1e-2, 1e-4}) {
      const auto f = [&](double x) { return h.characteristic(x) * h(x) / (mu + x); };
      const double right = 1 - mu * integrator.integrate(f, 0.0, 1.0);
      EXPECT_NEAR(1 / h(mu), right, 2e-12) << c << ' ' << mu;
    }
  }
}

TEST(HFunction, SeriesAgreesWithTheIntegral) {
  double worst = 0;
  for (const double c : kAlbedos) {
    const HFunction h = isotropic_h(c);
    for (double mu = 1; mu > 1e-12; mu *= 0.9)
      worst = std::max(worst, std::abs(h(mu) / h.by_quadrature(mu) - 1));
    EXPECT_NEAR(h(0), 1, 2e-12);
  }
  EXPECT_LT(worst, 2e-12);
}

TEST(HFunction, ZerothMomentOfTheIsotropicOneIsClosed) {
  // integral of Psi H = 1 - sqrt(1 - 2 integral of Psi), Chandrasekhar 1960, chapter V, theorem 2
  for (const double c : kAlbedos) {
    if (c == 0) continue;
    EXPECT_NEAR(isotropic_h(c).moment(0), 2 / c * (1 - std::sqrt(1 - c)), 1e-12 / std::min(c, 1.0))
        << c;
  }
  // 2 / sqrt(3), the first moment in the conservative case, same place
  EXPECT_NEAR(isotropic_h(1).moment(1), 2 / std::sqrt(3.0), 1e-12);
}

TEST(HFunction, ApproximationsKeepTheirStatedErrors) {
  double worst_1981 = 0, worst_2002 = 0;
  for (const double c : {0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 0.999, 1.0}) {
    const HFunction h = isotropic_h(c);
    for (int k = 0; k <= 200; ++k) {
      const double mu = k / 200.0;
      worst_1981 = std::max(worst_1981, std::abs(isotropic_h_hapke_1981(mu, c) / h(mu) - 1));
      worst_2002 = std::max(worst_2002, std::abs(isotropic_h_hapke_2002(mu, c) / h(mu) - 1));
    }
  }
  EXPECT_LT(worst_1981, 0.041);
  EXPECT_LT(worst_2002, 0.0097);
}

TEST(Chandrasekhar, IsReciprocalFiniteAndAddsUp) {
  const auto model = make_model("chandrasekhar", {{"albedo", Rgb(1, 0.5, 0)}});
  testing::expect_sane_values(*model, 2);
  testing::expect_reciprocal(*model);
}

TEST(Chandrasekhar, AlbedoEqualsQuadrature) {
  const auto model = make_model("chandrasekhar", {{"albedo", Rgb(1, 0.9, 0.3)}});
  testing::expect_albedo_equals_quadrature(*model);
  EXPECT_NEAR(model->albedo({0, 0, 1}).r, 1, 1e-15);
}

TEST(Chandrasekhar, SamplerFollowsItsPdf) {
  testing::expect_sampler_follows_its_pdf("chandrasekhar", *make_model("chandrasekhar", {}));
}

TEST(Chandrasekhar, SatisfiesThePrincipleOfInvariance) {
  // A thin layer added on top changes nothing: the nonlinear equation of f itself, which uses
  // nothing of the H function.
  const double c = 0.8;
  const auto model = make_model("chandrasekhar", {{"albedo", c}});
  boost::math::quadrature::tanh_sinh<double> integrator;
  const auto f = [&](double a, double b) {
    return model->eval(direction_from_mu_phi(a, 0), direction_from_mu_phi(b, 0)).r;
  };
  const auto collected = [&](double mu) {
    return 1 + 2 * kPi * mu * integrator.integrate([&](double x) { return f(mu, x); }, 1e-300, 1.0);
  };
  for (const double a : {1.0, 0.3})
    for (const double b : {0.7, 0.05})
      EXPECT_NEAR(f(a, b), c / (4 * kPi * (a + b)) * collected(a) * collected(b), 1e-11);
}

TEST(Chandrasekhar, AppliesToIsotropicHalfSpacesOnly) {
  const ModelInfo& info = *find_model("chandrasekhar");
  const auto applies = [&](const std::string& toml) {
    return info.applies_to(parse_stack(toml, "test", "test")).has_value();
  };
  const std::string hg = "[[layer]]\nmedium = \"henyey_greenstein\"\nalbedo = 0.7\n";
  EXPECT_TRUE(applies(hg + "thickness = inf\n"));
  EXPECT_FALSE(applies(hg + "thickness = 5\n"));
  EXPECT_FALSE(applies(hg + "g = 0.1\nthickness = inf\n"));
  const std::string sggx = "[[layer]]\nmedium = \"sggx\"\nthickness = inf\n";
  EXPECT_TRUE(applies(sggx + "roughness = 1\n"));
  EXPECT_TRUE(applies(sggx + "shape = \"fiber\"\nroughness = 1\n"));
  EXPECT_FALSE(applies(sggx + "roughness = 0.9\n"));
  EXPECT_FALSE(applies(sggx + "roughness = 1\nf0 = 0.04\n"));
  EXPECT_FALSE(applies(sggx + "roughness = 1\nflake = \"lambert\"\n"));
  const auto p = info.applies_to(parse_stack(hg + "thickness = inf\n", "test", "test"));
  EXPECT_EQ(p->color("albedo"), Rgb(0.7));
}

}  // namespace
}  // namespace lamella
