#include "analytic/layered/micrograin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/quadrature/gauss_kronrod.hpp>

#include "phase/surface/fresnel.h"
#include "tests/analytic/model/model_checks.h"
#include "tests/analytic/model/nested_quadrature.h"
#include "tests/statistics/statistics.h"

namespace lamella {
namespace {

using boost::math::quadrature::gauss_kronrod;
using testing::make_model;

const double kFillings[] = {0, 0.01, 0.5, 0.98, 0.9999};
const double kBetas[] = {0.05, 0.5, 1};

std::unique_ptr<Model> conductor(double tau0, double beta, const char* shadowing, double bulk = 0) {
  return make_model("micrograin", {{"tau0", tau0},
                                   {"beta", beta},
                                   {"surface", std::string("conductor")},
                                   {"shadowing", std::string(shadowing)},
                                   {"f0", Rgb(1, 0.5, 0.04)},
                                   {"bulk_albedo", bulk}});
}

TEST(Micrograin, IsReciprocalFiniteAndAddsUp) {
  for (const double tau0 : kFillings)
    for (const double beta : kBetas) {
      SCOPED_TRACE(tau0);
      const auto diffuse = make_model(
          "micrograin",
          {{"tau0", tau0}, {"beta", beta}, {"albedo", Rgb(1, 0.4, 0)}, {"bulk_albedo", 0.3}});
      testing::expect_sane_values(*diffuse, 2);
      testing::expect_reciprocal(*diffuse);
      for (const char* shadowing : {"ggx", "smith"}) {
        const auto model = conductor(tau0, beta, shadowing, 0.3);
        testing::expect_sane_values(*model, 2);
        testing::expect_reciprocal(*model);
      }
    }
}

TEST(Micrograin, LimitsOfTheFillingFactor) {
  const Direction wi = direction_from_degrees(40, 0), wo = direction_from_degrees(70, 100);
  // No grains: the surface below.
  EXPECT_NEAR(make_model("micrograin", {{"tau0", 0.0}, {"bulk_albedo", 0.6}})->eval(wi, wo).r,
              0.6 / kPi, 1e-16);
  // White grains on a white surface: Lambert.
  EXPECT_NEAR(make_model("micrograin", {{"bulk_albedo", 1.0}})->eval(wi, wo).r, 1 / kPi, 1e-15);
}

TEST(Micrograin, NormalsAreNormalisedAndFollowTheirCdf) {
  for (const double tau0 : kFillings)
    for (const double beta : kBetas) {
      const auto f = [&](double theta) {
        const double mu = std::cos(theta);
        return 2 * kPi * std::sin(theta) * mu * micrograin_ndf(mu, tau0, beta);
      };
      const auto share = [&](double to) {
        return gauss_kronrod<double, 61>::integrate(f, 0.0, to, 12, 1e-12);
      };
      EXPECT_NEAR(share(kPi / 2), 1, 1e-11) << tau0 << ' ' << beta;
      EXPECT_NEAR(share(0.7), micrograin_ndf_cdf(std::cos(0.7), tau0, beta), 1e-11);
      for (const double xi : {0.0, 0.01, 0.3, 0.9, 0.999})
        EXPECT_NEAR(micrograin_ndf_cdf(micrograin_ndf_sample(xi, tau0, beta), tau0, beta), xi,
                    1e-15 / (beta * beta))  // the rounding of the cosine
            << tau0 << ' ' << beta;
    }
}

TEST(Micrograin, RadicandOfEquation20IsNegativeAsPrinted) {
  const double xi = 0.3, tau0 = 0.5;
  const double a = std::log(1 - xi * tau0), b = std::log(1 - tau0);
  EXPECT_NEAR(a / (a - b), -0.306, 5e-4);
  const double tangent = 0.4 * std::sqrt(a / (b - a));
  EXPECT_NEAR(micrograin_ndf_sample(xi, tau0, 0.4), 1 / std::sqrt(1 + tangent * tangent), 1e-15);
}

TEST(Micrograin, EquivalentRoughnessMatchesGgxAtTheNormal) {
  // GGX at its normal is 1 / (pi alpha^2); tau0 = 0.98 leaves at most 0.5005 (section 4.2).
  for (const double tau0 : {0.1, 0.7}) {
    const double alpha = micrograin_equivalent_roughness(tau0, 0.6);
    EXPECT_NEAR(micrograin_ndf(1, tau0, 0.6), 1 / (kPi * alpha * alpha), 1e-13);
  }
  EXPECT_NEAR(micrograin_equivalent_roughness(0.98, 1), 0.5005, 5e-5);
}

TEST(Micrograin, VisibleFillingFactorIsThatOfTheShadows) {
  // The shadow of an upper half ellipsoid on the base plane, counted on a grid: eqs. 21, 22 say
  // that its area is that of the disc times (1 + gamma / cos) / 2.
  for (const double beta : {0.4, 1.0})
    for (const double theta : {0.5, 1.2}) {
      const double s = std::sin(theta), c = std::cos(theta);
      const double reach = 1 + 1 / c;
      constexpr int kCells = 800;
      int hit = 0;
      for (int i = 0; i < kCells; ++i)
        for (int j = 0; j < kCells; ++j) {
          // From (x, y, 0) along (s, 0, c): is z^2 / beta^2 + x^2 + y^2 = 1 met at some z >= 0?
          const double x = -reach + (i + 0.5) / kCells * (reach + 1);
          const double y = -1 + (j + 0.5) / kCells * 2;
          const double qa = s * s + c * c / (beta * beta), qb = x * s, qc = x * x + y * y - 1;
          const double root = qb * qb - qa * qc;
          hit += root >= 0 && -qb + std::sqrt(root) >= 0;
        }
      const double area = hit * (reach + 1) * 2 / (kCells * kCells);
      for (const double tau0 : {0.2, 0.8})
        EXPECT_NEAR(micrograin_tau_plus(c, tau0, beta), 1 - std::pow(1 - tau0, area / kPi), 5e-4)
            << beta << ' ' << theta;
    }
}

TEST(Micrograin, WeightFollowsFromTheVisibleFillingFactors) {
  const double tau0 = 0.4, beta = 0.7;
  for (const double x : {1.0, 0.3})
    for (const double y : {0.8, 0.1}) {
      const double i = micrograin_tau_plus(x, tau0, beta), o = micrograin_tau_plus(y, tau0, beta);
      EXPECT_NEAR(micrograin_weight(x, y, tau0, beta), 1 - (1 - i) * (1 - o) / (1 - tau0), 1e-15);
      // eqs. 21, 22, 24 as powers
      const auto tau = [&](double mu) { return micrograin_tau(mu, tau0, beta); };
      const double gamma = std::sqrt(x * x + beta * beta * (1 - x * x));
      EXPECT_NEAR(tau(x), 1 - std::pow(1 - tau0, gamma / x), 1e-15);
      EXPECT_NEAR(i, 1 - std::sqrt((1 - tau(x)) * (1 - tau0)), 1e-15);
      EXPECT_NEAR(micrograin_weight(x, y, tau0, beta), 1 - std::sqrt((1 - tau(x)) * (1 - tau(y))),
                  1e-15);
    }
  EXPECT_NEAR(micrograin_weight(1, 1, tau0, beta), tau0, 1e-15);
}

TEST(Micrograin, Equation26HoldsWithBetaAndAPower) {
  // (1 - tau0)^(1 / G(0, theta)) = 1 - tau_plus, G that of GGX with roughness beta itself.
  const double tau0 = 0.6, beta = 0.5;
  for (const double mu : {0.9, 0.4, 0.05}) {
    const auto identity = [&](double alpha) {
      const double inverse_g = 0.5 * (1 + std::sqrt(1 + alpha * alpha * (1 - mu * mu) / (mu * mu)));
      return std::pow(1 - tau0, inverse_g) - (1 - micrograin_tau_plus(mu, tau0, beta));
    };
    EXPECT_NEAR(identity(beta), 0, 1e-15);
    EXPECT_GT(std::abs(identity(micrograin_equivalent_roughness(tau0, beta))), 1e-3);
  }
}

TEST(Micrograin, ProjectedAreaIsTheIntegralOverTheNormals) {
  for (const double tau0 : {0.0, 0.3, 0.98})
    for (const double beta : {0.3, 1.0})
      for (const double mu : {1.0, 0.6, 0.1, 1e-4}) {
        const Direction w = direction_from_mu_phi(mu, 0);
        const auto f = [&](Direction m) {
          return micrograin_ndf(m.z, tau0, beta) * std::max(0.0, dot(w, m)) / m.z;
        };
        EXPECT_NEAR(micrograin_projected_area(mu, tau0, beta, MicrograinShadowing::smith) /
                        integrate_projected(f, 1, 1e-7),
                    1, 1e-6)
            << tau0 << ' ' << beta << ' ' << mu;
      }
}

TEST(Micrograin, GgxShadowingIsExactForIsolatedGrainsAndConservativeOtherwise) {
  double worst = 0;
  for (const double beta : {0.1, 0.5, 1.0})
    for (const double tau0 : {0.0, 0.5, 0.98})
      for (double mu = 0.005; mu <= 1; mu += 0.005) {
        const double ggx = micrograin_projected_area(mu, tau0, beta, MicrograinShadowing::ggx);
        const double smith = micrograin_projected_area(mu, tau0, beta, MicrograinShadowing::smith);
        EXPECT_TRUE(tau0 > 0 || std::abs(ggx / smith - 1) < 1e-9) << beta << ' ' << mu;
        worst = std::max(worst, std::abs(mu / ggx - mu / smith));
      }
  EXPECT_LT(worst, 0.10);
}

TEST(Micrograin, ConductorsDoNotGainEnergy) {
  for (const double tau0 : {0.3, 0.98}) {
    const auto model = conductor(tau0, 0.7, "smith");
    for (const double mu : {1.0, 0.3, 0.02}) {
      const Direction wi = direction_from_mu_phi(mu, 0);
      const auto f = [&](Direction wo) { return model->eval(wi, wo).r; };
      EXPECT_LT(integrate_projected(f, 1, 1e-5), 1) << tau0 << ' ' << mu;
    }
  }
}

TEST(Micrograin, SamplersFollowTheirPdf) {
  testing::expect_sampler_follows_its_pdf("micrograin", *make_model("micrograin", {}));
  const auto model = make_model("micrograin", {{"beta", 0.6},
                                               {"surface", std::string("conductor")},
                                               {"normals", std::string("all")},
                                               {"bulk_albedo", 0.5}});
  for (const double theta : {0.0, 50.0, 85.0}) {
    const Direction wo = direction_from_degrees(theta, 40);
    const auto pdf = [&](Direction wi) { return model->pdf(wi, wo); };
    // About -w_o, where the density of reflections has its integrable pole.
    EXPECT_NEAR(testing::integrate_sphere(pdf, -wo, 1e-5), 1, 1e-3) << theta;
    const auto sample = [&](RandomStream& stream) {
      const double u1 = stream.uniform(), u2 = stream.uniform(), u3 = stream.uniform();
      return *model->sample(wo, u1, u2, u3);
    };
    EXPECT_GT(testing::sampler_p_value("micrograin", -wo, sample, pdf, 100000),
              testing::test_level())
        << theta;
  }
}

// Of GGX, index 1.5.
std::unique_ptr<Model> over_glass(double tau0, const char* surface = "lambert",
                                  Rgb albedo = Rgb(0)) {
  return make_model("micrograin", {{"tau0", tau0},
                                   {"beta", 0.6},
                                   {"surface", std::string(surface)},
                                   {"albedo", albedo},
                                   {"bulk", std::string("microfacet")},
                                   {"bulk_material", std::string("dielectric")},
                                   {"bulk_ior", 1.5},
                                   {"bulk_roughness", 0.3}});
}

TEST(Micrograin, GlassPassesWhatTheGrainsAboveLeaveOfIt) {
  const auto bare = over_glass(0), model = over_glass(0.4);
  const Direction up = direction_from_degrees(55, 10), down = direction_from_degrees(155, 200);
  const double seen = 1 - micrograin_tau_plus(up.z, 0.4, 0.6);
  EXPECT_GT(bare->eval(up, down).r, 0);
  EXPECT_NEAR(model->eval(up, down).r, seen * bare->eval(up, down).r, 1e-14);
  EXPECT_NEAR(model->eval(down, up).r, seen * bare->eval(down, up).r, 1e-14);
  // Radiance over n^2 is reciprocal.
  EXPECT_NEAR(model->eval(up, down).r, 2.25 * model->eval(down, up).r, 1e-14);
  // The light of black grains is that of the glass alone.
  const auto passed = [&](const Model& m) {
    return integrate_projected([&](Direction w) { return m.eval(up, w).r; }, -1, 1e-6);
  };
  EXPECT_NEAR(passed(*model), seen * passed(*bare), 1e-5);
  // From below, the bases of grains are Lambertian discs.
  const Direction other = direction_from_degrees(120, 0);
  const auto white = over_glass(0.4, "lambert", Rgb(1));
  EXPECT_NEAR(white->eval(down, other).r, 0.4 / kPi + 0.6 * bare->eval(down, other).r, 1e-14);
  // What is opaque passes nothing, as before.
  EXPECT_EQ(make_model("micrograin", {})->eval(up, down), Rgb());
}

TEST(Micrograin, OverGlassSamplersFollowTheirPdf) {
  for (const double theta : {20.0, 75.0, 110.0, 160.0}) {
    const auto model = over_glass(0.4, "conductor", Rgb(1));
    const Direction wo = direction_from_degrees(theta, 40);
    const auto pdf = [&](Direction wi) { return model->pdf(wi, wo); };
    // What the sampler gives up on, by both counts.
    double found = 0;
    constexpr int kSamples = 200000;
    double weight = 0, square = 0;
    RandomStream stream(7, static_cast<std::uint64_t>(theta), StreamPurpose::measure);
    for (int k = 0; k < kSamples; ++k) {
      const double u1 = stream.uniform(), u2 = stream.uniform(), u3 = stream.uniform();
      const auto wi = model->sample(wo, u1, u2, u3);
      if (!wi) continue;
      found += 1.0 / kSamples;
      const double w = model->eval(*wi, wo).r * std::abs(wi->z) / pdf(*wi);
      weight += w / kSamples;
      square += w * w / kSamples;
    }
    EXPECT_GT(found, 0.9) << theta;
    // The mean weight is the integral over both sides, which cubature finds on its own.
    const double whole =
        integrate_projected([&](Direction w) { return model->eval(w, wo).r; }, 1, 1e-6) +
        integrate_projected([&](Direction w) { return model->eval(w, wo).r; }, -1, 1e-6);
    EXPECT_NEAR(weight, whole, 5 * std::sqrt((square - weight * weight) / kSamples) + 1e-4)
        << theta;
  }
}

TEST(Micrograin, FirstTermsOfTheSeriesKeepTheirStatedError) {
  double worst = 0;
  for (const double beta : {0.1, 0.5, 1.0})
    for (const double tau0 : {0.0, 0.5, 0.98})
      for (double mu = 0.01; mu <= 1; mu += 0.01) {
        const auto area = [&](MicrograinShadowing s, int n) {
          return micrograin_projected_area(mu, tau0, beta, s, n);
        };
        const double exact = area(MicrograinShadowing::smith, 0);
        EXPECT_NEAR(area(MicrograinShadowing::series, 200) / exact, 1, 1e-12);
        worst = std::max(worst, std::abs(mu / area(MicrograinShadowing::series, 4) - mu / exact));
      }
  EXPECT_LT(worst, 0.026);
  EXPECT_GT(worst, 0.02);
}

TEST(Micrograin, VisibleNormalsFollowTheirDensity) {
  for (const double tau0 : {0.0, 0.5, 0.98})
    for (const double mu : {1.0, 0.4, 0.0}) {
      const double beta = 0.6;
      const Direction w = direction_from_mu_phi(mu, 0.7);
      const double area = micrograin_projected_area(std::max(mu, kGrazingLimit), tau0, beta,
                                                    MicrograinShadowing::smith);
      const auto density = [&](Direction m) {
        return m.z > 0 ? micrograin_ndf(m.z, tau0, beta) * std::max(0.0, dot(w, m)) / area : 0;
      };
      const auto sample = [&](RandomStream& stream) {
        return micrograin_visible_normal(w, tau0, beta, stream);
      };
      EXPECT_GT(testing::sampler_p_value("visible", Direction{0, 0, 1}, sample, density, 50000),
                testing::test_level())
          << tau0 << ' ' << mu;
    }
}

TEST(Micrograin, SpecularGrainsSampledByVisibleNormalsFollowTheirPdf) {
  for (const char* surface : {"conductor", "dielectric"})
    testing::expect_sampler_follows_its_pdf(
        surface,
        *make_model("micrograin", {{"beta", 0.6},
                                   {"surface", std::string(surface)},
                                   {"bulk", std::string("eon")},
                                   {"bulk_roughness", 1.0},
                                   {"bulk_albedo", 0.5}}),
        1e-4);
}

TEST(Micrograin, WhiteDielectricGrainsKeepTheEnergy) {
  // What is left is the error of this quadrature: the albedo of their specular part, which stands
  // in a table, has 1e-6.
  double worst = 0;
  for (const char* shadowing : {"ggx", "smith"})
    for (const double beta : {0.03, 0.3, 1.0}) {
      const auto model = make_model("micrograin", {{"tau0", 0.8},
                                                   {"beta", beta},
                                                   {"surface", std::string("dielectric")},
                                                   {"shadowing", std::string(shadowing)},
                                                   {"bulk_albedo", 1.0}});
      testing::expect_sane_values(*model, 2);
      testing::expect_reciprocal(*model);
      // The weight depends on both directions, so only white on white is a furnace of grains: with
      // w constant (normal incidence and beta small) it is that of f_S.
      for (const double mu : {1.0, 0.5, 0.1, 0.03}) {
        const Direction wi = direction_from_mu_phi(mu, 0);
        const auto grains = [&](Direction wo) {
          const double w = micrograin_weight(mu, std::max(wo.z, kGrazingLimit), 0.8, beta);
          return model->eval_lobe(0, wi, wo).r / w;
        };
        worst = std::max(worst, std::abs(integrate_projected(grains, 1, 1e-5) - 1));
      }
    }
  EXPECT_LT(worst, 2e-5);
}

TEST(Micrograin, FresnelAtADielectric) {
  EXPECT_NEAR(fresnel_reflectance(1, 1.5), 0.04, 1e-15);
  EXPECT_NEAR(fresnel_reflectance(0, 1.5), 1, 1e-15);
  // Brewster's angle: parallel light passes whole, so half of the perpendicular reflectance is
  // left.
  const double n = 1.5, brewster = std::cos(std::atan(n));
  const double rs = (1 - n * n) / (1 + n * n);
  EXPECT_NEAR(fresnel_reflectance(brewster, n), 0.5 * rs * rs, 1e-15);
}

TEST(Micrograin, AnyClosedFormMayLieBelow) {
  const Direction wi = direction_from_degrees(50, 0), wo = direction_from_degrees(30, 70);
  for (const char* bulk : {"eon", "vmf_diffuse", "lambert_sphere", "oren_nayar_full"}) {
    const auto below = make_model(bulk, {{"albedo", Rgb(0.8, 0.5, 0.1)}});
    const auto both = make_model(
        "micrograin",
        {{"tau0", 0.3}, {"bulk", std::string(bulk)}, {"bulk_albedo", Rgb(0.8, 0.5, 0.1)}});
    const double w = micrograin_weight(wi.z, wo.z, 0.3, 0.5);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(both->eval_lobe(1, wi, wo)[c], (1 - w) * below->eval(wi, wo)[c], 1e-15) << bulk;
  }
}

// Two closed forms with a key of one name, of different ranges, defaults and texts; their value is
// that key's.
ModelInfo constant_model(const std::string& name, double most, const std::string& default_value) {
  class Constant final : public Model {
   public:
    explicit Constant(double value) : Model(1), value_(value) {}
    [[nodiscard]] Rgb eval_lobe(int /*lobe*/, Direction /*wi*/, Direction /*wo*/) const override {
      return Rgb(value_);
    }

   private:
    double value_;
  };
  return {.name = name,
          .doc = "",
          .source = "",
          .parameters = {{.name = "roughness",
                          .unit = "1",
                          .doc = "of " + name,
                          .default_value = default_value,
                          .min = 0,
                          .max = most}},
          .lobes = {{"all", ""}},
          .make = [](const Parameters& p,
                     const Stack*) { return std::make_unique<Constant>(p.number("roughness")); },
          .applies_to = nullptr};
}

TEST(Micrograin, KeysOfTheBulkAreItsOwn) {
  const ModelInfo info =
      micrograin_model({constant_model("first", 1, "0.5"), constant_model("second", 2, "1.5")});
  EXPECT_EQ(find(info.parameters, "bulk")->choices, (std::vector<std::string>{"first", "second"}));
  EXPECT_EQ(find(info.parameters, "bulk_roughness"), nullptr);
  const Direction up{0, 0, 1};
  for (const auto& [bulk, most, value] : {std::tuple("first", 1.0, 0.5), {"second", 2.0, 1.5}}) {
    Parameters p;
    p.set("bulk", std::string(bulk));
    const std::vector<ParameterInfo> infos = parameters_of(info, p);
    const ParameterInfo& key = *find(infos, "bulk_roughness");
    EXPECT_EQ(key.max, most);
    EXPECT_EQ(key.default_value, to_text(value));
    EXPECT_EQ(key.doc, std::string("of the surface below: of ") + bulk);
    p.set("tau0", 0.0);
    Parameters given = p;
    fill_defaults(infos, p);
    EXPECT_DOUBLE_EQ(info.make(p, nullptr)->eval(up, up).r, value);
    // Without the bulk's keys it has its own defaults; what it does not allow is refused by name.
    fill_defaults(info.parameters, given);
    EXPECT_DOUBLE_EQ(info.make(given, nullptr)->eval(up, up).r, value);
    given.set("bulk_roughness", 1.75);
    if (most > 1.75) {
      EXPECT_DOUBLE_EQ(info.make(given, nullptr)->eval(up, up).r, 1.75);
      continue;
    }
    try {
      (void)info.make(given, nullptr);
      FAIL() << "1.75 was taken";
    } catch (const ParameterError& error) {
      EXPECT_EQ(error.key, "bulk_roughness");
    }
  }
}

TEST(Micrograin, OffersTheParametersOfEveryBulkAsThatModelHasThem) {
  const ModelInfo& info = *find_model("micrograin");
  const std::vector<std::string>& bulks = find(info.parameters, "bulk")->choices;
  EXPECT_EQ(std::count(bulks.begin(), bulks.end(), "micrograin"), 0);
  EXPECT_EQ(std::count(bulks.begin(), bulks.end(), "spongecake"), 0);
  for (const std::string& bulk : bulks) {
    const std::vector<ParameterInfo> infos = parameters_of(info, bulk);
    for (const ParameterInfo& own : find_model(bulk)->parameters) {
      const ParameterInfo* key = find(infos, "bulk_" + own.name);
      ASSERT_NE(key, nullptr) << bulk << ' ' << own.name;
      EXPECT_EQ(allowed_values(*key), allowed_values(own)) << bulk << ' ' << own.name;
      // The albedo is 0 by default: grains alone.
      EXPECT_EQ(key->default_value, own.name == "albedo" ? "0" : own.default_value) << bulk;
    }
  }
}

TEST(Micrograin, PartsAnswerForTheirDirections) {
  const ModelInfo& info = *find_model("micrograin");
  Parameters p;
  p.set("tau0", 0.3);
  p.set("beta", 0.8);
  fill_defaults(info.parameters, p);
  p.set("shadowing", std::string("smith"));
  const Direction wi = direction_from_mu_phi(0.6, 1), wo = direction_from_mu_phi(0.2, 2);
  ASSERT_EQ(info.parts.size(), 5u);
  EXPECT_EQ(info.parts[0].eval(p, wi, wo).r, micrograin_ndf(wi.z, 0.3, 0.8));
  EXPECT_EQ(info.parts[2].eval(p, wi, wo).r, micrograin_tau_plus(wi.z, 0.3, 0.8));
  EXPECT_EQ(info.parts[3].eval(p, wi, wo).r, micrograin_weight(wi.z, wo.z, 0.3, 0.8));
  EXPECT_EQ(info.parts[1].eval(p, wi, wo).r, micrograin_tau(wi.z, 0.3, 0.8));
  EXPECT_NEAR(info.parts[4].eval(p, wi, wo).r,
              wi.z / micrograin_projected_area(wi.z, 0.3, 0.8, MicrograinShadowing::smith), 1e-15);
}

}  // namespace
}  // namespace lamella
