#include "analytic/facets/microfacet_model.h"

#include <gtest/gtest.h>

#include "phase/interface/dielectric.h"
#include "phase/surface/conductor.h"
#include "tests/analytic/model/model_checks.h"
#include "tests/analytic/model/nested_quadrature.h"
#include "tests/statistics/statistics.h"

namespace lamella {
namespace {

using testing::make_model;
using testing::test_level;
using Values = std::vector<std::pair<std::string, ParameterValue>>;

ParameterValue word(const char* text) { return std::string(text); }

std::unique_ptr<Model> facets(Values values) { return make_model("microfacet", values); }

TEST(Microfacet, ValuesAreSaneAtEveryEndOfTheParameters) {
  for (const char* distribution : {"ggx", "beckmann"})
    for (const double alpha : {1e-4, 0.3, 1.0})
      for (const char* compensation : {"none", "kulla_conty", "turquin"})
        for (const auto& [eta, k] : {std::pair{0.2, 3.9}, {1.5, 0.0}, {1.0, 20.0}}) {
          // Tables take a while.
          if (std::string(compensation) != "none" && (eta != 0.2 || alpha < 0.3)) continue;
          SCOPED_TRACE(::testing::Message() << distribution << ' ' << alpha << ' ' << compensation
                                            << ' ' << eta << ' ' << k);
          const auto model = facets({{"distribution", word(distribution)},
                                     {"roughness", alpha},
                                     {"compensation", word(compensation)},
                                     {"eta", eta},
                                     {"k", k}});
          // facet_batch_test.cpp derives how far batches of facets may be off.
          testing::expect_sane_values(*model, 2, false, 200);
          const bool turquin = std::string(compensation) == "turquin";
          if (!turquin) testing::expect_reciprocal(*model, 1e-11);
          // Turquin's furnace is the viewer's: of light from grazing directions up to 2.03 leaves.
          for (const double mu : {1.0, 0.3, 1e-4, kGrazingLimit})
            EXPECT_LT(model->albedo(direction_from_mu_phi(mu, 1)).r, turquin ? 2.1 : 1 + 1e-7)
                << mu;
        }
}

TEST(Microfacet, SingleScatteringIsThatOfThePhaseRoom) {
  const Facets shape{FacetShape::beckmann, 0.2, 0.5};
  const Conductor conductor(
      {.facets = shape, .masking = Masking::separable, .eta = Rgb(0.5), .k = Rgb(2)});
  const auto model = facets({{"distribution", word("beckmann")},
                             {"roughness", 0.2},
                             {"roughness_y", 0.5},
                             {"masking", word("separable")},
                             {"eta", 0.5},
                             {"k", 2.0}});
  const Direction wi = direction_from_mu_phi(0.6, 1), wo = direction_from_mu_phi(0.7, 3.5);
  EXPECT_EQ(model->eval(wi, wo), conductor.single(wi, wo));
}

TEST(Microfacet, TransmissionIsReciprocalWithTheIndexSquared) {
  for (const char* compensation : {"none", "kulla_conty"})
    for (const double ior : {1.0001, 1.5, 3.0, 0.7}) {
      if (ior != 1.5 && std::string(compensation) != "none") continue;  // tables take a while
      const auto glass = facets(
          {{"material", word("dielectric")}, {"ior", ior}, {"compensation", word(compensation)}});
      for (const double mu_i : {0.9, 0.3, 1e-3})
        for (const double mu_o : {0.8, 0.1})
          for (const double phi : {0.0, 2.0, 3.1}) {
            const Direction w = direction_from_mu_phi(mu_i, 0);
            const Direction below = direction_from_mu_phi(-mu_o, phi);
            const double there = glass->eval(w, below).g / (ior * ior);
            const double back = glass->eval(below, w).g;
            EXPECT_NEAR(there, back, 1e-7 * there) << ior << ' ' << mu_i << ' ' << mu_o;
            const Direction above = direction_from_mu_phi(mu_o, phi);
            EXPECT_NEAR(glass->eval(w, above).g, glass->eval(above, w).g,
                        1e-11 * glass->eval(above, w).g);
            EXPECT_NEAR(glass->eval(-w, -above).g, glass->eval(-above, -w).g,
                        1e-11 * glass->eval(-above, -w).g);
          }
    }
}

TEST(Microfacet, AlbedoIsTheIntegralOfTheValues) {
  for (const char* material : {"conductor", "dielectric", "white"})
    for (const char* compensation : {"none", "kulla_conty", "turquin"})
      for (const double mu : {0.3, -0.5}) {
        if (mu < 0 && std::string(material) != "dielectric") continue;
        if (mu > 0 && std::string(material) == "dielectric" && std::string(compensation) != "none")
          continue;  // from below alone: each takes seconds
        const auto model = facets({{"material", word(material)},
                                   {"roughness", 0.5},
                                   {"compensation", word(compensation)}});
        const Direction wi = direction_from_mu_phi(mu, 0.3);
        const DirectionalIntegral integral = integrate_projected(
            [&](std::span<const Direction> directions, std::span<Rgb> values) {
              for (std::size_t k = 0; k < directions.size(); ++k)
                values[k] = model->eval(wi, directions[k]);
            },
            wi, std::array{1.0, -1.0}, {.tolerance = 1e-4});
        const AlbedoEstimate albedo = model->albedo_with_error(wi);
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(albedo.value[c], integral.value[c],
                      albedo.error[c] + integral.error[c] + 1e-7 * albedo.value[c])
              << material << ' ' << compensation << ' ' << mu;
      }
}

TEST(Microfacet, WhiteFacetsKeepAllEnergyWithKullaContyAndAlongTheViewWithTurquin) {
  for (const char* distribution : {"ggx", "beckmann"})
    for (const char* material : {"white", "dielectric"})
      for (const double alpha : {0.1, 1.0}) {
        // Tables of dielectrics take seconds.
        const bool ggx = std::string(distribution) == "ggx";
        if (std::string(material) == "dielectric" && ggx == (alpha == 1)) continue;
        const auto model = facets({{"material", word(material)},
                                   {"distribution", word(distribution)},
                                   {"roughness", alpha},
                                   {"compensation", word("kulla_conty")}});
        for (const double mu : {1.0, 0.4, 0.02, 1e-7, -1e-7, -0.3, -0.9}) {
          if (mu < 0 && std::string(material) == "white") continue;
          // Below 1e-6 tables miss how slowly the Beta masking goes to its limit.
          EXPECT_NEAR(model->albedo(direction_from_mu_phi(mu, 0)).g, 1,
                      std::abs(mu) < 1e-6 ? 1e-3 : 1e-5)
              << distribution << ' ' << material << ' ' << alpha << ' ' << mu;
        }
      }
  // Turquin's furnace is that of the viewer.
  const auto turquin =
      facets({{"material", word("white")}, {"roughness", 0.6}, {"compensation", word("turquin")}});
  for (const double mu : {0.9, 0.3}) {
    const Direction wo = direction_from_mu_phi(mu, 0);
    EXPECT_NEAR(integrate_projected([&](Direction wi) { return turquin->eval(wi, wo).g; }, 1, 1e-6),
                1, 1e-5);
  }
}

// A sample that is none counts as one of a uniform sphere.
void expect_samples_follow_their_density(const Model& model, Direction wo, double width) {
  const Direction axis = wo.z > 0 ? Direction{-wo.x, -wo.y, wo.z} : -wo;
  const testing::SphereCells cells{.axis = axis, .width = width};
  const double whole =
      testing::integrate_sphere([&](Direction wi) { return model.pdf(wi, wo); }, cells, 1e-6);
  EXPECT_LE(whole, 1 + 1e-4);
  const auto sample = [&](RandomStream& stream) {
    const double u1 = stream.uniform(), u2 = stream.uniform(), u3 = stream.uniform();
    const auto wi = model.sample(wo, u1, u2, u3);
    return wi ? *wi : uniform_sphere(stream.uniform(), stream.uniform());
  };
  const auto pdf = [&](Direction wi) {
    return model.pdf(wi, wo) + std::fmax(1 - whole, 0) / (4 * kPi);
  };
  EXPECT_GT(testing::sampler_p_value("microfacet", cells, sample, pdf, 50000), test_level())
      << wo.z << ' ' << whole;
}

TEST(Microfacet, SamplesFollowTheirDensity) {
  for (const char* material : {"conductor", "dielectric"})
    for (const char* compensation : {"none", "kulla_conty"})
      for (const double alpha : {0.3, 0.8}) {
        // Quadrature over a density takes a while.
        const bool conductor = std::string(material) == "conductor";
        if ((alpha > 0.5 || !conductor) && std::string(compensation) != "none") continue;
        if (alpha > 0.5 && !conductor) continue;
        SCOPED_TRACE(::testing::Message() << material << ' ' << compensation << ' ' << alpha);
        const auto model = facets({{"material", word(material)},
                                   {"roughness", alpha},
                                   {"compensation", word(compensation)}});
        for (const double theta : {10.0, 120.0}) {
          if ((theta == 10) != conductor) continue;
          expect_samples_follow_their_density(*model, direction_from_degrees(theta, 40), 0.5);
        }
      }
}

TEST(Microfacet, WeightsOfSamplesHaveTheAlbedoAsMean) {
  for (const double alpha : {1e-4, 0.05, 0.9}) {
    const auto model = facets({{"roughness", alpha}, {"roughness_y", alpha * 1.1}});
    const Direction wo = direction_from_mu_phi(0.4, 1);
    RandomStream stream(3, 0, StreamPurpose::test);
    std::vector<double> weights;
    for (int n = 0; n < 20000; ++n) {
      const double u1 = stream.uniform(), u2 = stream.uniform();
      const Direction wi = *model->sample(wo, u1, u2, stream.uniform());
      weights.push_back(wi.z > 0 ? model->eval(wi, wo).g * wi.z / model->pdf(wi, wo) : 0);
    }
    EXPECT_GT(testing::mean_p_value(weights, model->albedo(wo).g), test_level()) << alpha;
  }
}

TEST(Microfacet, CompensationIsRefusedForTwoRoughnesses) {
  EXPECT_THROW(facets({{"roughness_y", 0.5}, {"compensation", word("turquin")}}), ParameterError);
  EXPECT_THROW(facets({{"material", word("dielectric")}, {"ior", 1.0}}), ParameterError);
  EXPECT_THROW(facets({{"roughness", 0.0}}), ParameterError);
}

}  // namespace
}  // namespace lamella
