#include "analytic/rough_surface/beckmann_diffuse.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/gauss_kronrod.hpp>

#include "analytic/model/stochastic_model.h"
#include "tests/analytic/model/model_checks.h"
#include "tests/analytic/model/nested_quadrature.h"
#include "tests/statistics/statistics.h"

namespace lamella {
namespace {

using boost::math::quadrature::gauss_kronrod;
using testing::make_model;

double ndf(Direction m, double alpha) {
  if (m.z <= 0) return 0;
  const double c2 = m.z * m.z, t2 = (1 - m.z) * (1 + m.z) / c2;
  return std::exp(-t2 / (alpha * alpha)) / (kPi * alpha * alpha * c2 * c2);
}

/// Integral of D(m) g(m) dm over the slopes of the facets, g less than quadratic in them.
template <class G>
double over_facets(double alpha, const G& g) {
  const auto at = [&](double p) {
    return gauss_kronrod<double, 31>::integrate(
        [&](double q) {
          const Direction m = normalized(Direction{-alpha * p, -alpha * q, 1});
          return std::exp(-p * p - q * q) / kPi / m.z * g(m);
        },
        -6.5, 6.5, 10, 1e-10);
  };
  return gauss_kronrod<double, 31>::integrate(at, -6.5, 6.5, 10, 1e-10);
}

std::unique_ptr<Model> model_of(double alpha, double albedo = 1, double walks = 4096) {
  return make_model("beckmann_diffuse", {{"alpha", alpha}, {"albedo", albedo}, {"walks", walks}});
}

ValueWithError estimate(const Model& model, Direction wi, Direction wo) {
  return dynamic_cast<const StochasticModel&>(model).eval_with_error(wi, wo);
}

TEST(BeckmannDiffuse, ProjectedAreaIsTheIntegralOverTheFacets) {
  for (const double alpha : {0.2, 1.4})
    for (const double mu : {1.0, 0.6, 0.05, 0.0, -0.3, -0.8}) {
      const Direction w = direction_from_mu_phi(mu, 0);
      const double exact =
          over_facets(alpha, [&](Direction m) { return std::max(0.0, dot(w, m)); });
      EXPECT_NEAR(beckmann_projected_area(w, alpha), exact, 2e-8) << alpha << ' ' << mu;
      // The vertical mean normal: sigma(w) - sigma(-w) = mu.
      EXPECT_NEAR(beckmann_projected_area(w, alpha) - beckmann_projected_area(-w, alpha), mu,
                  1e-15);
    }
}

TEST(BeckmannDiffuse, VisibleNormalsFollowTheirDensity) {
  for (const double alpha : {0.3, 1.4})
    for (const double mu : {1.0, 0.5, 0.01, -0.4}) {
      const Direction w = direction_from_mu_phi(mu, 0.7);
      const double area = beckmann_projected_area(w, alpha);
      const auto density = [&](Direction m) {
        return std::max(0.0, dot(w, m)) * ndf(m, alpha) / area;
      };
      const auto sample = [&](RandomStream& stream) {
        const double u1 = stream.uniform(), u2 = stream.uniform();
        return beckmann_visible_normal(w, alpha, u1, u2);
      };
      EXPECT_GT(testing::sampler_p_value("beckmann", Direction{0, 0, 1}, sample, density, 50000),
                testing::test_level())
          << alpha << ' ' << mu;
    }
}

TEST(BeckmannDiffuse, SingleScatteringEqualsItsQuadrature) {
  // f_1 = albedo / pi integral of D <w_i, m> <w_o, m> dm / (mu_i mu_o (1 + Lambda_i + Lambda_o))
  const double alpha = 0.8;
  for (const double mu_i : {1.0, 0.4, 0.05})
    for (const double mu_o : {0.9, 0.2, 0.01})
      for (const double phi : {0.0, 2.0}) {
        const Direction wi = direction_from_mu_phi(mu_i, 0), wo = direction_from_mu_phi(mu_o, phi);
        const double facing = over_facets(alpha, [&](Direction m) {
          return std::max(0.0, dot(wi, m)) * std::max(0.0, dot(wo, m));
        });
        const double ai = beckmann_projected_area(wi, alpha);
        const double ao = beckmann_projected_area(wo, alpha);
        const double exact = 0.7 * facing / kPi / (mu_o * ai + mu_i * ao - mu_i * mu_o);
        // The lobe alone has no error estimate: that of a second roughness-free bound, the scatter
        // of eight seeds.
        std::vector<double> values;
        for (int seed = 1; seed <= 8; ++seed)
          values.push_back(make_model("beckmann_diffuse", {{"alpha", alpha},
                                                           {"albedo", 0.7},
                                                           {"walks", 4096.0},
                                                           {"seed", static_cast<double>(seed)}})
                               ->eval_lobe(0, wi, wo)
                               .r);
        double mean = 0, square = 0;
        for (const double v : values) mean += v / 8;
        for (const double v : values) square += (v - mean) * (v - mean) / 7;
        // Student's t with 7 degrees of freedom: 9.7 at a level of 2.5e-5.
        EXPECT_NEAR(mean, exact, 9.7 * std::sqrt(square / 8) + 1e-9)
            << mu_i << ' ' << mu_o << ' ' << phi;
      }
}

TEST(BeckmannDiffuse, WhiteFurnaceIsOneAndReciprocityHoldsWithinTheNoise) {
  for (const double alpha : {0.3, 1.4, 4.0}) {
    const auto model = model_of(alpha, 1, 20000);
    for (const double mu : {1.0, 0.3, 0.02}) {
      const Direction wi = direction_from_mu_phi(mu, 0);
      EXPECT_EQ(model->albedo(wi), Rgb(1));
      // By what arrives, not by what leaves: Gauss's rule is good to 1e-3 for these smooth lobes;
      // 20000 walks have a standard error of at most 0.007 (spread 1).
      double energy = 0;
      constexpr int kMu = 24, kPhi = 16;
      for (int i = 0; i < kMu; ++i)
        for (int j = 0; j < kPhi; ++j) {
          const double x = (i + 0.5) / kMu;
          const Direction wo = direction_from_mu_phi(x * x, 2 * kPi * (j + 0.5) / kPhi);
          energy += model->eval(wi, wo).g * x * x * 2 * x / kMu * 2 * kPi / kPhi;
        }
      EXPECT_NEAR(energy, 1, 0.03) << alpha << ' ' << mu;
      for (const double mu_o : {0.8, 0.1}) {
        const Direction wo = direction_from_mu_phi(mu_o, 2.2);
        const ValueWithError f = estimate(*model, wi, wo), g = estimate(*model, wo, wi);
        EXPECT_NEAR(f.f.g, g.f.g, 4.5 * std::hypot(f.standard_error.g, g.standard_error.g))
            << alpha << ' ' << mu << ' ' << mu_o;
      }
    }
  }
}

TEST(BeckmannDiffuse, StandardErrorIsTheScatterBetweenSeeds) {
  const Direction wi = direction_from_degrees(60, 0), wo = direction_from_degrees(30, 100);
  double square = 0, mean = 0, stated = 0;
  constexpr int kSeeds = 200;
  std::vector<double> values;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const auto model =
        make_model("beckmann_diffuse",
                   {{"alpha", 1.0}, {"walks", 256.0}, {"seed", static_cast<double>(seed)}});
    const ValueWithError f = estimate(*model, wi, wo);
    values.push_back(f.f.g);
    mean += f.f.g / kSeeds;
    stated += f.standard_error.g / kSeeds;
  }
  for (const double v : values) square += (v - mean) * (v - mean) / (kSeeds - 1);
  EXPECT_NEAR(std::sqrt(square) / stated, 1, 0.25);  // 5 standard deviations of such a ratio
}

TEST(BeckmannDiffuse, LobesAddUpAndLimitsHold) {
  const auto model = model_of(0.9, 0.6, 256);
  testing::expect_sane_values(*model, 4);
  // alpha = 0 is Lambert, and small alpha comes near it: by its second order in alpha.
  const Direction wi = direction_from_degrees(40, 0), wo = direction_from_degrees(20, 120);
  EXPECT_EQ(model_of(0, 0.6)->eval(wi, wo), 1 / kPi * Rgb(0.6));
  EXPECT_NEAR(model_of(0.02, 0.6, 20000)->eval(wi, wo).g, 0.6 / kPi, 1e-3);
  // One walk's events are the same for every w_o: f has no noise between neighbours.
  const double step = 1e-4;
  const double a = model->eval(wi, direction_from_mu_phi(0.5, 1)).g;
  const double b = model->eval(wi, direction_from_mu_phi(0.5 + step, 1)).g;
  EXPECT_LT(std::abs(a - b), 10 * step);
}

}  // namespace
}  // namespace lamella
