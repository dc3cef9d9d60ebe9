#include "analytic/coated/coated_model.h"

#include <gtest/gtest.h>

#include "analytic/coated/coat.h"
#include "analytic/facets/facet_integral.h"
#include "phase/math/sampling.h"
#include "phase/surface/fresnel.h"
#include "tests/analytic/model/model_checks.h"
#include "tests/analytic/model/nested_quadrature.h"
#include "tests/statistics/statistics.h"

namespace lamella {
namespace {

using testing::make_model;
using testing::test_level;
using Values = std::vector<std::pair<std::string, ParameterValue>>;

constexpr FacetShape kShapes[] = {FacetShape::ggx, FacetShape::beckmann};
constexpr const char* kLayerings[] = {"albedo_scaling", "albedo_scaling_reciprocal", "darkened",
                                      "saunderson", "wolff"};

ParameterValue word(const char* text) { return std::string(text); }

std::unique_ptr<Model> coated(const char* layering, double ior, double alpha, Values more = {}) {
  Values values{{"layering", word(layering)}, {"ior", ior}, {"roughness", alpha}};
  values.insert(values.end(), more.begin(), more.end());
  return make_model("coated", values);
}

Direction at(double mu, double phi) { return direction_from_mu_phi(mu, phi); }

// Energy of light that leaves along w_o when it arrives uniformly.
double seen(const Model& model, Direction wo, int lobe) {
  return integrate_projected([&](Direction wi) { return model.eval_lobe(lobe, wi, wo).g; }, 1,
                             1e-8);
}

TEST(Coat, TablesHoldTheirError) {
  double worst = 0, worst_through = 0;
  for (const FacetShape shape : kShapes)
    for (const double alpha : {1e-4, 0.1, 1.0})
      for (const double n : {1.0001, 1.5, 3.0}) {
        const bool through = alpha >= 0.1 && n == 1.5;
        const Coat coat(coat_interface(shape, alpha, n), Rgb(0.5), through);
        const Facets facets{shape, alpha, alpha};
        for (double mu = 1; mu > 1e-6; mu *= 0.41) {
          const double r = reflected_share<double>(
              facets, Masking::beta, at(mu, 0),
              [n](double cosine, Direction) {
                return fresnel_reflectance(std::fmin(cosine, 1), n);
              },
              1e-9);
          if (n > 1.1) worst = std::max(worst, std::abs(coat.reflected(mu) / r - 1));
          // Next to index 1 Fresnel's reflectance has a peak 0.01 wide, and quadrature its trouble.
          EXPECT_NEAR(coat.reflected(mu) / r, 1, n < 1.1 ? 2e-5 : 1e-6)
              << to_text(shape) << ' ' << alpha << ' ' << n << ' ' << mu;
          if (!through) continue;
          const double t = refracted_share(
              facets, Masking::beta, n, at(mu, 0),
              [](double cosine) { return std::pow(0.5, 0.5 / cosine); }, 1e-8);
          worst_through = std::max(worst_through, std::abs(coat.transmitted(mu).g - t));
          EXPECT_NEAR(coat.transmitted(mu).g, t, 2e-6)
              << to_text(shape) << ' ' << alpha << ' ' << n << ' ' << mu;
        }
      }
  std::printf("E: %g, T: %g\n", worst, worst_through);
}

// From below: what is not reflected is refracted, n^2 of the mean from above, or lost.
TEST(Coat, InternalReflectionIsWhatEnergyLeaves) {
  for (const FacetShape shape : kShapes)
    for (const double alpha : {0.1, 0.6})
      for (const double n : {1.5}) {
        const Dielectric interface = coat_interface(shape, alpha, n);
        const Coat coat(interface, Rgb(1), true);
        using Rule = boost::math::quadrature::gauss<double, 20>;
        const double through = Rule::integrate(
            [&](double x) { return 4 * x * x * x * coat.transmitted(x * x).g; }, 0.0, 1.0);
        const double critical = std::sqrt(1 - 1 / (n * n));
        const auto lost = [&](double mu) {
          return 2 * mu * lost_share(interface.facets, Masking::beta, 1 / n, at(mu, 0), 1e-5);
        };
        const double lost_below =
            Rule::integrate(lost, 0.0, critical) + Rule::integrate(lost, critical, 1.0);
        EXPECT_NEAR(coat.internal_mean().g + through / (n * n) + lost_below, 1, 3e-5)
            << to_text(shape) << ' ' << alpha << ' ' << n;
      }
}

TEST(Coat, SmoothOnesHaveClosedForms) {
  for (const double n : {1.0001, 1.3, 1.5, 2.0, 3.0}) {
    const Coat coat(coat_interface(FacetShape::ggx, 0, n), Rgb(1), true);
    const double outside = mean_fresnel_reflectance(n);
    EXPECT_NEAR(coat.fresnel_mean(), outside, 1e-8) << n;
    EXPECT_NEAR(coat.internal_mean().g, 1 - (1 - outside) / (n * n), 1e-8) << n;
    EXPECT_NEAR(coat.transmitted(0.4).g, 1 - fresnel_reflectance(0.4, n), 1e-14);
  }
  // Diffuse light, n = 1.5.
  const Coat glass(coat_interface(FacetShape::ggx, 0, 1.5), Rgb(1), true);
  EXPECT_NEAR(glass.fresnel_mean(), 0.0918, 5e-5);
  EXPECT_NEAR(glass.internal_mean().g, 0.5963, 5e-5);
}

// f = (1 - F_i) (1 - F_o) rho / (pi n^2 (1 - rho F_int)), and what an absorbing coat makes of it.
TEST(Coated, SaundersonIsExactForASmoothCoatOverLambert) {
  const double rho = 0.7;
  for (const double n : {1.0001, 1.5, 3.0})
    for (const double color : {1.0, 0.4}) {
      const auto model = coated("saunderson", n, 0, {{"base.albedo", rho}, {"color", color}});
      const double outside = mean_fresnel_reflectance(n);
      const auto inside = [n](double mu) { return std::sqrt(1 - (1 - mu * mu) / (n * n)); };
      // 2 F(mu', 1 / n) color^(1 / mu') mu' dmu' over the coat's hemisphere.
      using boost::math::quadrature::gauss_kronrod;
      const double critical = inside(0);
      const auto back = [&](double mu) {
        return mu > 0 ? 2 * mu * fresnel_reflectance(mu, 1 / n) * std::pow(color, 1 / mu) : 0;
      };
      const double returns =
          color == 1 ? 1 - (1 - outside) / (n * n)
                     : gauss_kronrod<double, 31>::integrate(back, 0.0, critical, 15, 1e-12) +
                           gauss_kronrod<double, 31>::integrate(back, critical, 1.0, 15, 1e-12);
      for (const double mu_i : {1.0, 0.4, 0.01})
        for (const double mu_o : {0.9, 0.2}) {
          const auto t = [&](double mu) {
            return (1 - fresnel_reflectance(mu, n)) * std::pow(color, 0.5 / inside(mu));
          };
          const double exact = t(mu_i) * t(mu_o) * rho / (kPi * n * n * (1 - rho * returns));
          EXPECT_NEAR(model->eval(at(mu_i, 0), at(mu_o, 2)).g, exact, 1e-7 * exact);
        }
    }
}

TEST(Coated, SaundersonUnderARoughCoatIsTheSumOfItsBounces) {
  const double rho = 0.8, n = 1.5, alpha = 0.3;
  const Dielectric interface = coat_interface(FacetShape::ggx, alpha, n);
  const auto model = coated("saunderson", n, alpha, {{"base.albedo", rho}});
  const Direction wi = at(0.5, 0);
  // Light that is refracted to below, is spread by Lambert's law, and meets the interface from
  // within until it leaves or is lost.
  RandomStream stream(5, 0, StreamPurpose::test);
  std::vector<double> leaves(200000);
  for (double& total : leaves) {
    auto ray = interface.scatter(wi, stream);
    if (ray.wo.z > 0) continue;
    double weight = ray.kept;
    while (weight > 1e-9) {
      weight *= rho;
      const double u1 = stream.uniform(), u2 = stream.uniform();
      const Direction up = cosine_hemisphere(Direction{0, 0, 1}, u1, u2);
      ray = interface.scatter(-up, stream);
      weight *= ray.kept;
      if (ray.wo.z > 0) {
        total = weight;
        break;
      }
    }
  }
  const double base =
      integrate_projected([&](Direction wo) { return model->eval_lobe(1, wi, wo).g; }, 1, 1e-8);
  EXPECT_GT(testing::mean_p_value(leaves, base), test_level()) << base;
}

// E_c = F + E_b (1 - F) Delta of a smooth coat over Lambert, seen along w_o.
TEST(Coated, DarkeningIsExactForASmoothCoatOverLambertAlongTheView) {
  for (const double n : {1.3, 1.5, 2.0})
    for (const double rho : {0.05, 0.5, 1.0})
      for (const double mu : {1.0, 0.5, 0.1}) {
        const Direction wo = at(mu, 0);
        const double found = seen(*coated("darkened", n, 0, {{"base.albedo", rho}}), wo, 1);
        const double exact = seen(*coated("saunderson", n, 0, {{"base.albedo", rho}}), wo, 1);
        EXPECT_NEAR(found, exact, 2e-7) << n << ' ' << rho << ' ' << mu;
      }
}

TEST(Coated, WhiteBasesKeepTheEnergyThatTheirLayeringPromises) {
  for (const char* distribution : {"ggx", "beckmann"})
    for (const auto& [alpha, n] : {std::pair{1e-4, 3.0}, {0.1, 1.5}, {0.1, 1.0001}, {1.0, 1.5}}) {
      const Values shape{{"distribution", word(distribution)}};
      const auto whole = coated("albedo_scaling_reciprocal", n, alpha, shape);
      const auto openpbr = coated("albedo_scaling", n, alpha, shape);
      const auto wolff = coated("wolff", n, alpha, shape);
      const Coat coat(coat_interface(facet_shape_from(distribution), alpha, n), Rgb(1), false);
      for (const double mu : {1.0, 0.05, 1e-7}) {
        SCOPED_TRACE(::testing::Message() << distribution << ' ' << alpha << ' ' << n << ' ' << mu);
        const Direction w = at(mu, 0);
        EXPECT_NEAR(whole->albedo(w).g, 1, 2e-6);
        // Albedo scaling: the viewer's furnace, whose coat part is E by reciprocity.
        EXPECT_NEAR(coat.reflected(mu) + seen(*openpbr, w, 1), 1, 2e-6);
        EXPECT_LT(wolff->albedo(w).g, 1 + 1e-6);
      }
    }
}

TEST(Coated, ValuesAreSaneAndReciprocalWhereClaimed) {
  for (const char* layering : kLayerings)
    for (const auto& [alpha, n] :
         {std::pair{0.0, 1.0}, {0.0, 1.0001}, {0.0, 3.0}, {1e-4, 3.0}, {0.3, 1.0001}, {1.0, 3.0}}) {
      // Tables of transmitted light take a second each.
      if (std::string(layering) == "saunderson" && alpha == 1e-4) continue;
      SCOPED_TRACE(::testing::Message() << layering << ' ' << alpha << ' ' << n);
      const auto model =
          coated(layering, n, alpha, {{"color", Rgb(0.9, 0.5, 0)}, {"base.albedo", 0.8}});
      testing::expect_sane_values(*model, 2);
      if (std::string(layering) != "albedo_scaling" && std::string(layering) != "darkened")
        testing::expect_reciprocal(*model, 1e-11);
    }
}

TEST(Coated, AnIndexOfOneDoesNothing) {
  for (const char* layering : kLayerings) {
    const auto model = coated(layering, 1, 0.3, {{"base", word("eon")}, {"base.roughness", 0.7}});
    const auto base = make_model("eon", {{"roughness", 0.7}});
    const Direction wi = at(0.6, 0), wo = at(0.3, 2);
    EXPECT_NEAR(model->eval(wi, wo).g, base->eval(wi, wo).g, 1e-9) << layering;
    EXPECT_EQ(model->specular(wi), Rgb(0)) << layering;
  }
}

TEST(Coated, ASmoothCoatIsADeltaOverTheBase) {
  const auto model = coated("albedo_scaling_reciprocal", 1.5, 0);
  const Direction wi = at(0.4, 0);
  EXPECT_EQ(model->eval_lobe(0, wi, at(0.4, kPi)), Rgb(0));
  EXPECT_NEAR(model->specular(wi).g, fresnel_reflectance(0.4, 1.5), 1e-15);
  EXPECT_NEAR(model->specular(wi).g + model->albedo(wi).g, 1, 1e-7);
}

TEST(Coated, AnyClosedFormMayLieBelow) {
  const ModelInfo& info = *find_model("coated");
  for (const std::string& base : find(info.parameters, "base")->choices) {
    SCOPED_TRACE(base);
    const auto model = coated("albedo_scaling", 1.5, 0.2, {{"base", base}});
    const double f = model->eval(at(0.7, 0), at(0.6, 1)).g;
    EXPECT_TRUE(std::isfinite(f) && f > 0);
    EXPECT_EQ(model->eval(at(0.7, 0), at(-0.6, 1)), Rgb(0));
  }
  EXPECT_THROW(coated("wolff", 1.5, 0.1, {{"base", word("microfacet")}, {"base.albedo", 0.5}}),
               ParameterError);
}

TEST(Coated, AlbedoIsTheIntegralOfTheValues) {
  for (const char* layering : {"albedo_scaling", "darkened", "saunderson"})
    testing::expect_albedo_equals_quadrature(
        *coated(layering, 1.5, 0.4,
                {{"base", word("eon")}, {"base.albedo", 0.6}, {"color", Rgb(0.9, 0.5, 0.1)}}),
        3e-7);
}

TEST(Coated, SamplesFollowTheirDensity) {
  testing::expect_sampler_follows_its_pdf(
      "coated eon", *coated("albedo_scaling", 1.5, 0.4, {{"base", word("eon")}}), 1e-5);
  testing::expect_sampler_follows_its_pdf("coated metal",
                                          *coated("albedo_scaling", 1.5, 0.7,
                                                  {{"distribution", word("beckmann")},
                                                   {"base", word("microfacet")},
                                                   {"base.roughness", 0.5}}),
                                          1e-5);
  testing::expect_sampler_follows_its_pdf("coated smooth", *coated("saunderson", 1.5, 0), 1e-6);
}

TEST(OpenPbrDiffuse, IsTheCoatedFormByOtherNames) {
  const auto slab = make_model("openpbr_diffuse", {{"base_weight", 0.5},
                                                   {"base_color", Rgb(0.8, 0.4, 0.2)},
                                                   {"base_diffuse_roughness", 0.6},
                                                   {"specular_roughness", 0.4}});
  const auto same =
      coated("albedo_scaling", 1.5, 0.4 * 0.4,
             {{"base", word("eon")}, {"base.albedo", Rgb(0.4, 0.2, 0.1)}, {"base.roughness", 0.6}});
  const Direction wi = at(0.6, 0), wo = at(0.5, 2.9);
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(slab->eval(wi, wo)[c], same->eval(wi, wo)[c], 1e-12 * slab->eval(wi, wo)[c]);
  EXPECT_EQ(find_model("openpbr_diffuse")->lobes[0].order, Order::zero);
}

TEST(OpenPbrDiffuse, SpecularWeightScalesTheReflectanceAtNormalIncidence) {
  const Direction up{0, 0, 1};
  for (const double weight : {0.0, 0.5, 2.0}) {
    const auto slab =
        make_model("openpbr_diffuse", {{"specular_weight", weight}, {"specular_roughness", 0.0}});
    EXPECT_NEAR(slab->specular(up).g, 0.04 * weight, 1e-14);
  }
}

TEST(OpenPbrDiffuse, ValuesAreSaneAndTheTintIsOfTheCoatAlone) {
  for (const double r : {0.0, 0.1, 1.0})
    for (const char* layering : {"albedo_scaling", "albedo_scaling_reciprocal"}) {
      const Values values{
          {"specular_roughness", r}, {"base_diffuse_roughness", 1.0}, {"layering", word(layering)}};
      const auto slab = make_model("openpbr_diffuse", values);
      testing::expect_sane_values(*slab, 2);
      if (std::string(layering) != "albedo_scaling") testing::expect_reciprocal(*slab, 1e-11);
      Values tinted = values;
      tinted.emplace_back("specular_color", Rgb(1, 0.5, 0));
      const auto red = make_model("openpbr_diffuse", tinted);
      const Direction wi = at(0.7, 0), wo = at(0.7, kPi);
      EXPECT_EQ(red->eval_lobe(1, wi, wo), slab->eval_lobe(1, wi, wo));
      EXPECT_EQ(red->eval_lobe(0, wi, wo).g, 0.5 * slab->eval_lobe(0, wi, wo).g);
    }
}

}  // namespace
}  // namespace lamella
