#include <gtest/gtest.h>

#include <cmath>
#include <type_traits>

#include "analytic/half_space/vmf_diffuse_formula.h"
#include "analytic/model/grazing_pair.h"
#include "analytic/model/stochastic_model.h"
#include "analytic/rough_surface/eon_formula.h"
#include "analytic/rough_surface/oren_nayar_formula.h"
#include "tests/analytic/model/model_checks.h"

namespace lamella {
namespace {

using testing::make_model;

constexpr double kTiny[] = {5e-324, 1e-300, 1e-160};
constexpr double kAzimuths[] = {0, 50, 90, 140, 180};

// At an azimuth in degrees, 180 being exact.
Direction at(double mu, double phi) {
  Direction w = direction_from_degrees(90, phi);
  const double s = std::sqrt((1 - mu) * (1 + mu));
  return {s * w.x, s * w.y, mu};
}

/// The largest error of a formula in double against the same in 80 bits, relative to its value or
/// to 1e-3 / sr, over cosines from 1 to 1e-150.
template <class Formula>
double worst_rounding(const Formula& formula) {
  using Long = long double;
  double worst = 0;
  const double cosines[] = {1, 0.7, 0.1, 1e-3, 1e-7, 1e-12, 1e-16, 1e-30, 1e-80, 1e-150};
  for (const double mu_i : cosines)
    for (const double mu_o : cosines)
      for (const double phi : kAzimuths) {
        const Direction wi = at(mu_i, 0), wo = at(mu_o, phi);
        const auto found = formula.channel(formula.shared(*reflection_angles(wi, wo)), 0);
        const Angles<Long> angles =
            angles_above(Vec3<Long>{wi.x, wi.y, wi.z}, Vec3<Long>{wo.x, wo.y, wo.z});
        const Long right = formula.channel(formula.shared(angles), 0);
        const Long error = std::abs(found - right) / std::max(std::abs(right), Long(1e-3));
        EXPECT_TRUE(std::isfinite(found)) << mu_i << ' ' << mu_o << ' ' << phi;
        worst = std::max(worst, static_cast<double>(error));
        EXPECT_LT(error, 1e-12) << mu_i << ' ' << mu_o << ' ' << phi << ": " << found << " for "
                                << static_cast<double>(right);
      }
  return worst;
}

TEST(Grazing, FormulasKeepTheirDigitsWhereBothCosinesAreSmall) {
  EXPECT_GT(worst_rounding(EonFormula<EonAlbedo::exact>{
                .single = {0.2, 0.2, 0.2}, .multiple = {3, 3, 3}, .roughness = 0.9}),
            0);
  worst_rounding(EonFormula<EonAlbedo::none>{
      .single = {0.2, 0.2, 0.2}, .multiple = {0, 0, 0}, .roughness = 1});
  worst_rounding(QualitativeFormula<false>{.rho = {0.3, 0.3, 0.3}, .a = {0.8, 0.8, 0.8}, .b = 0.4});
  worst_rounding(QualitativeFormula<true>{.rho = {0.3, 0.3, 0.3}, .a = {0.8, 0.8, 0.8}, .b = 0.4});
  worst_rounding(FullOrenNayarFormula{.rho = {0.3, 0.3, 0.3},
                                      .rho2 = {0.3, 0.3, 0.3},
                                      .c1 = 0.7,
                                      .c2 = 0.4,
                                      .c3 = 0.1,
                                      .interaction = 0.1});
  for (const double r : {0.01, 0.5, 1.0}) worst_rounding(vmf_diffuse_formula(Rgb(0.8), r, false));
}

// Every model that is made without a stack, at its defaults.
template <class F>
void for_models(const F& f) {
  for (const ModelInfo& info : models())
    if (!info.needs_stack) {
      SCOPED_TRACE(info.name);
      f(info, *make_model(info.name, {}));
    }
}

TEST(Grazing, OneCosineAtZeroIsTheLimitFromAbove) {
  for_models([](const ModelInfo& info, const Model& model) {
    const auto* stochastic = dynamic_cast<const StochasticModel*>(&model);
    for (const double mu : {1.0, 0.6, 1e-3})
      for (const double phi : kAzimuths) {
        const Direction w = at(mu, 20), zero = at(0, 20 + phi), near = at(1e-13, 20 + phi);
        for (const bool incident : {true, false}) {
          const auto f = [&](Direction grazing) {
            return incident ? model.eval(grazing, w) : model.eval(w, grazing);
          };
          const Rgb limit = f(zero);
          // Models go to their limit like mu^0.45 or faster: 1.4e-6 at 1e-13, over mu.
          double tolerance = 3e-5 * (limit.g + 1 / mu);
          if (stochastic)
            tolerance += 6 * (incident ? stochastic->eval_with_error(zero, w)
                                       : stochastic->eval_with_error(w, zero))
                                 .standard_error.g;
          EXPECT_NEAR(f(near).g, limit.g, tolerance) << mu << ' ' << phi << ' ' << incident;
          // What is smaller than the limit's stand-in is the limit.
          for (const double tiny : kTiny)
            EXPECT_EQ(f(at(tiny, 20 + phi)), limit) << mu << ' ' << tiny << ' ' << incident;
        }
        for (const double tiny : kTiny) {
          EXPECT_TRUE(std::isfinite(model.pdf(at(tiny, 0), w))) << tiny;
          EXPECT_TRUE(std::isfinite(model.pdf(w, at(tiny, 0)))) << tiny;
        }
        EXPECT_TRUE(std::isfinite(model.albedo(with_grazing_limit(zero)).g));
      }
    EXPECT_FALSE(info.lobes.empty());
  });
}

std::optional<Rgb> limit(const Model& model, double phi) {
  return limit_where_both_graze([&](Direction i, Direction o) { return model.eval(i, o); },
                                at(0, 0), at(0, phi));
}

TEST(Grazing, BothCosinesAtZeroHaveNoLimitInMostModels) {
  for (const char* name : {"chandrasekhar",
                           "lambert_sphere",
                           "lambert_sphere_fast",
                           "lambert_sphere_three_term",
                           "lambert_sphere_three_term_pure",
                           "hapke_lambert_sphere",
                           "vmf_diffuse",
                           "vmf_diffuse_printed",
                           "oren_nayar_full",
                           "oren_nayar",
                           "oren_nayar_footnote",
                           "fujii_qualitative",
                           "fon",
                           "eon",
                           "eon_approx",
                           "beckmann_diffuse",
                           "microfacet",
                           "sheen_conty_kulla",
                           "coated",
                           "openpbr_diffuse"})
    EXPECT_FALSE(limit(*make_model(name, {}), 0)) << name;
  EXPECT_FALSE(limit(*make_model("micrograin", {{"surface", std::string("conductor")}}), 0));
  // No grains: the surface below.
  EXPECT_FALSE(limit(
      *make_model("micrograin",
                  {{"tau0", 0.0}, {"bulk", std::string("chandrasekhar")}, {"bulk_albedo", 0.5}}),
      0));
}

TEST(Grazing, BothCosinesAtZeroHaveTheLimitOfThoseThatAreFinite) {
  const Rgb rho(0.7, 0.5, 0);
  const auto expect = [&](const Model& model, double phi, double right, const char* what) {
    const auto found = limit(model, phi);
    ASSERT_TRUE(found) << what;
    EXPECT_NEAR(found->r, right, 1e-13) << what;
  };
  for (const double phi : {0.0, 77.0, 180.0}) {
    expect(*make_model("lambert", {{"albedo", rho}}), phi, 0.7 / kPi, "lambert");
    expect(*make_model("eon", {{"albedo", rho}, {"roughness", 0.0}}), phi, 0.7 / kPi, "eon, r = 0");
    expect(*make_model("oren_nayar", {{"albedo", rho}, {"sigma", 0.0}}), phi, 0.7 / kPi,
           "oren_nayar, sigma = 0");
    expect(*make_model("vmf_diffuse", {{"albedo", rho}, {"roughness", 0.0}}), phi, 0.7 / kPi,
           "vmf_diffuse, r = 0");
    expect(*make_model("chandrasekhar", {{"albedo", 0.0}}), phi, 0, "chandrasekhar, albedo 0");
    // All light meets grains.
    expect(*make_model("micrograin", {{"albedo", rho}}), phi, 0.7 / kPi, "micrograin");
  }
  // Opposite azimuths: Fujii's s is -1 over t = 1, and what is lost has come back to 0.
  const double r = 0.6, a = 1 / (1 + kFonNormalLoss * r);
  expect(*make_model("eon", {{"albedo", rho}, {"roughness", r}}), 180, 0.7 * a * (1 - r) / kPi,
         "eon");
  // The full model: C1 - C2 (sin(alpha) - (2 beta / pi)^3) tan(beta), whose last factors go to
  // 6 / pi, and twice the interreflection.
  const double s2 = 0.25, c1 = 1 - 0.5 * s2 / (s2 + 0.33), c2 = 0.45 * s2 / (s2 + 0.09);
  expect(*make_model("oren_nayar_full", {{"albedo", rho}, {"sigma", 0.5}}), 180,
         0.7 / kPi * (c1 - c2 * 6 / kPi) + 0.49 / kPi * 2 * 0.17 * s2 / (s2 + 0.13), "full");
}

TEST(Grazing, LimitsThatDependOnTheWayAreNone) {
  const auto find = [](const std::function<double(double, double)>& f) {
    return limit_where_both_graze([&](Direction i, Direction o) { return Rgb(f(i.z, o.z)); },
                                  at(0, 0), at(0, 30));
  };
  EXPECT_FALSE(find([](double x, double y) { return x / (x + y); }));
  EXPECT_FALSE(find([](double x, double y) { return -std::log(x + y); }));
  EXPECT_FALSE(find([](double x, double y) { return 1e-100 / (x + y); }));
  EXPECT_FALSE(find([](double, double) { return std::nan(""); }));
  EXPECT_LT(find([](double x, double y) { return std::sqrt(x * y); })->r, 1e-100);
  EXPECT_EQ(find([](double, double) { return 3.0; })->r, 3);
}

}  // namespace
}  // namespace lamella
