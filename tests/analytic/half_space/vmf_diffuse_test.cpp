#include "analytic/half_space/vmf_diffuse.h"

#include <gtest/gtest.h>

#include "analytic/half_space/lambert_sphere_models.h"
#include "analytic/half_space/vmf_sigma_fit.h"
#include "analytic/layered/single_scattering_model.h"
#include "phase/stack/stack_file.h"
#include "tests/analytic/model/model_checks.h"
#include "tests/analytic/model/nested_quadrature.h"
#include "tests/analytic/model/successive_orders.h"

namespace lamella {
namespace {

using testing::make_model;

Stack vmf_half_space(double roughness) {
  return parse_stack("[[layer]]\nmedium = \"vmf_flake\"\nthickness = inf\nroughness = " +
                         std::to_string(roughness) + "\n",
                     "test", "test");
}

template <class Fit>
double worst_error(const Fit& fit, double from, double to) {
  double worst = 0;
  for (int k = 0; k <= 24; ++k) {
    const double alpha = from + (to - from) * k / 24;
    for (double u = -1; u <= 1; u += 0.0625)
      worst = std::max(worst, std::abs(fit(u, alpha) - vmf_sigma(u, alpha)));
  }
  return worst;
}

TEST(VmfSigmaFit, KeepsItsStatedErrors) {
  const double smooth = worst_error(vmf_sigma_fit_smooth, 0.02, 0.25);
  const double middle = worst_error(vmf_sigma_fit_middle, 0.25, 0.9);
  const double rough = worst_error(vmf_sigma_fit_rough, 0.9, 3);
  EXPECT_LT(smooth, 9.5e-4);
  EXPECT_LT(middle, 0.024);
  EXPECT_LT(rough, 2.1e-3);
  for (const double u : {-1.0, -0.3, 0.0, 0.6, 1.0}) {
    EXPECT_EQ(vmf_sigma_fit(u, 0), std::max(0.0, u));
    EXPECT_NEAR(vmf_sigma_fit(u, 1e-3), std::max(0.0, u), 3e-4);
    EXPECT_EQ(vmf_sigma_fit(u, std::numeric_limits<double>::infinity()), 0.25);
    EXPECT_NEAR(vmf_sigma_fit(u, 1000), 0.25 + u / 3e6, 1e-12);
  }
}

TEST(VmfSigmaFit, PrintedSignOfEquation4IsUnbounded) {
  // exp(+u^2 / (alpha^2 (1 - u^2))) instead of exp(-...), alpha = 0.2, u = 0.5
  const double alpha = 0.2, u = 0.5;
  const double width = alpha * std::sqrt(1 - u * u), x = u / width;
  const double printed = vmf_sigma_fit_smooth(u, alpha) +
                         0.5 * width / std::sqrt(kPi) * (std::exp(x * x) - std::exp(-x * x));
  EXPECT_GT(printed, 200);
  EXPECT_NEAR(vmf_sigma(u, alpha), 0.49000505, 5e-9);
  EXPECT_NEAR(vmf_sigma_fit_smooth(u, alpha), vmf_sigma(u, alpha), 9.5e-4);
}

TEST(VmfSigmaFit, JumpsAtTheJointsAreThoseStated) {
  double first = 0, second = 0;
  for (double u = -1; u <= 1; u += 0.01) {
    first =
        std::max(first, std::abs(vmf_sigma_fit_middle(u, 0.25) - vmf_sigma_fit_smooth(u, 0.25)));
    second = std::max(second, std::abs(vmf_sigma_fit_rough(u, 0.9) - vmf_sigma_fit_middle(u, 0.9)));
  }
  EXPECT_NEAR(first, 6.7e-3, 1e-4);
  EXPECT_NEAR(second, 1.7e-2, 1e-3);
}

TEST(VmfDiffuse, IsReciprocalFiniteAndAddsUp) {
  for (const double r : {0.0, 1e-6, 0.03, 0.1, 0.3, 0.5, 0.8, 1.0}) {
    const auto model = make_model("vmf_diffuse", {{"albedo", Rgb(1, 0.6, 0)}, {"roughness", r}});
    testing::expect_sane_values(*model, 4);
    testing::expect_reciprocal(*model);
    const auto printed =
        make_model("vmf_diffuse_printed", {{"albedo", Rgb(1, 0.6, 0)}, {"roughness", r}});
    testing::expect_sane_values(*printed, 4, true);
    testing::expect_reciprocal(*printed);
  }
}

TEST(VmfDiffuse, ZeroRoughnessIsLambert) {
  const auto model = make_model("vmf_diffuse", {{"albedo", 0.7}, {"roughness", 0.0}});
  const Direction wi = direction_from_degrees(50, 0);
  for (const Direction wo : testing::probe_directions())
    EXPECT_EQ(model->eval(wi, wo), Rgb(0.7 * (1 / kPi)));
  // As printed f_m is not 0 there, and not even positive.
  EXPECT_NEAR(vmf_diffuse_higher_orders(1, 0, 1, 1), 0.0114, 5e-5);
  EXPECT_NEAR(vmf_diffuse_higher_orders(1, 0, 0.05, 0.05), -0.0276, 5e-5);
}

TEST(VmfDiffuse, FirstOrderOfTheCuredFormIsNearExactSingleScattering) {
  // Printed, the modes are half of the cosine coefficients: rms error 0.063 to 0.071; doubled,
  // 0.0025 to 0.012.
  for (const double r : {0.3, 0.6, 1.0}) {
    const Stack stack = vmf_half_space(r);
    const auto cured = make_model("vmf_diffuse", {{"roughness", r}});
    const auto printed = make_model("vmf_diffuse_printed", {{"roughness", r}});
    double cured_sum = 0, printed_sum = 0;
    int n = 0;
    for (const double mi : {0.1, 0.4, 0.7, 0.95})
      for (const double mo : {0.1, 0.4, 0.7, 0.95})
        for (const double phi : {0.0, 1.0, 2.0, 3.0}) {
          const Direction wi = direction_from_mu_phi(mi, 0), wo = direction_from_mu_phi(mo, phi);
          const double exact = single_scattering(stack, wi, wo).layers.r;
          cured_sum += std::pow(cured->eval_lobe(0, wi, wo).r - exact, 2);
          printed_sum += std::pow(printed->eval_lobe(0, wi, wo).r - exact, 2);
          ++n;
        }
    EXPECT_LT(std::sqrt(cured_sum / n), 0.012) << r;
    EXPECT_GT(std::sqrt(printed_sum / n), 0.06) << r;
  }
}

TEST(VmfDiffuse, PrintedFirstModesAreHalfOfTheExactOnesAtFullRoughness) {
  // At r = 1 the medium is Lambert spheres, whose orders are known independently. Least-squares
  // ratio of the exact cos phi coefficient to the printed one.
  const testing::SuccessiveOrders exact(testing::three_term_kernel(lambert_sphere_phase_terms(1)),
                                        1, 3);
  const auto& nodes = exact.nodes();
  for (int order = 1; order <= 3; ++order) {
    double product = 0, square = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (std::size_t j = 0; j < nodes.size(); ++j) {
        if (nodes[i] < 0.05 || nodes[j] < 0.05) continue;
        const double printed = vmf_diffuse_mode(order, 1, 1, nodes[i], nodes[j]);
        product += exact.order(order, i, j) * printed;
        square += printed * printed;
      }
    EXPECT_NEAR(product / square, 2, 0.05) << order;
  }
}

TEST(VmfDiffuse, SecondAndThirdOrderOfTheCuredFormAreNearTheExactOnes) {
  // At r = 1 and away from grazing; printed, the relative rms errors are 0.21 and 0.11.
  std::vector<testing::SuccessiveOrders> modes;
  for (int m = 0; m < 3; ++m)
    modes.emplace_back(testing::three_term_kernel(lambert_sphere_phase_terms(1)), m, 3);
  const auto cured = make_model("vmf_diffuse", {{"roughness", 1.0}});
  const auto& nodes = modes[0].nodes();
  for (int order = 2; order <= 3; ++order) {
    double error = 0, square = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (std::size_t j = 0; j < nodes.size(); ++j)
        for (const double phi : {0.0, 0.8, 1.6, 2.4, kPi}) {
          if (nodes[i] < 0.15 || nodes[j] < 0.15) continue;
          double exact = 0;
          for (int m = 0; m < 3; ++m) exact += modes[m].order(order, i, j) * std::cos(m * phi);
          const Direction wi = direction_from_mu_phi(nodes[i], 0);
          const Direction wo = direction_from_mu_phi(nodes[j], phi);
          error += std::pow(cured->eval_lobe(order - 1, wi, wo).r - exact, 2);
          square += exact * exact;
        }
    EXPECT_LT(std::sqrt(error / square), 0.06) << order;
  }
}

TEST(VmfDiffuse, AlbedoEqualsQuadrature) {
  for (const char* name : {"vmf_diffuse", "vmf_diffuse_printed"}) {
    const auto model = make_model(name, {{"albedo", 0.8}, {"roughness", 0.3}});
    const Direction wi = direction_from_degrees(65, 0);
    const auto f = [&](Direction wo) { return model->eval(wi, wo).r; };
    EXPECT_NEAR(model->albedo(wi).r, integrate_projected(f, 1, 1e-6), 1e-6);
  }
}

TEST(VmfDiffuse, SamplersFollowTheirPdf) {
  for (const double r : {0.0, 0.1, 1.0})
    testing::expect_sampler_follows_its_pdf("vmf_diffuse",
                                            *make_model("vmf_diffuse", {{"roughness", r}}), 1e-6);
  testing::expect_sampler_follows_its_pdf(
      "vmf_diffuse",
      *make_model("vmf_diffuse", {{"roughness", 0.5}, {"sampler", std::string("cosine")}}), 1e-6);
}

TEST(VmfDiffuse, FullRoughnessIsNearTheLambertSphere) {
  // Relative rms distance from the half space of Lambert spheres, measured: 0.047 for white flakes,
  // 0.025 for albedo 0.5.
  for (const auto& [albedo, distance] : {std::pair(1.0, 0.047), std::pair(0.5, 0.025)}) {
    const auto flakes = make_model("vmf_diffuse", {{"roughness", 1.0}, {"albedo", albedo}});
    const auto spheres = make_model("lambert_sphere_three_term", {{"albedo", albedo}});
    double error = 0, square = 0;
    for (const double mu_i : {0.15, 0.3, 0.6, 0.9})
      for (const double mu_o : {0.15, 0.3, 0.6, 0.9})
        for (int k = 0; k <= 4; ++k) {
          const Direction wi = direction_from_mu_phi(mu_i, 0);
          const Direction wo = direction_from_mu_phi(mu_o, k * kPi / 4);
          const double f = flakes->eval(wi, wo).g, g = spheres->eval(wi, wo).g;
          error += (f - g) * (f - g);
          square += g * g;
        }
    EXPECT_NEAR(std::sqrt(error / square), distance, 5e-4);
  }
}

TEST(VmfDiffuse, FittedLobesSaveVariance) {
  // Second moment of the weight f mu / pdf by quadrature: at least as good as the cosine law's, and
  // far better at grazing w_o.
  for (const double r : {0.1, 0.5, 1.0})
    for (const double theta : {20.0, 60.0, 85.0}) {
      const Direction wo = direction_from_degrees(theta, 30);
      const auto variance = [&](const char* sampler) {
        const auto model =
            make_model("vmf_diffuse", {{"roughness", r}, {"sampler", std::string(sampler)}});
        const auto square = [&](Direction wi) {
          const double f = model->eval(wi, wo).g;
          return wi.z > 0 ? f * f * wi.z / model->pdf(wi, wo) : 0;
        };
        const double mean = model->albedo(wo).g;
        return integrate_projected(square, 1, 1e-4) - mean * mean;
      };
      EXPECT_LT(variance("mis"), variance("cosine") * (theta > 80 ? 0.5 : 1.05))
          << r << ' ' << theta;
    }
}

TEST(VmfDiffuse, WhiteFurnaceErrorIsTheOneStated) {
  double low = 1, high = 1;
  for (int k = 1; k <= 40; ++k) {
    const auto model = make_model("vmf_diffuse", {{"roughness", k / 40.0}});
    for (const double mu : {1.0, 0.8, 0.6, 0.4, 0.2, 0.05}) {
      const double e = model->albedo(direction_from_mu_phi(mu, 0)).r;
      low = std::min(low, e);
      high = std::max(high, e);
    }
  }
  EXPECT_GT(low, 0.89);
  EXPECT_LT(high, 1.09);
}

TEST(VmfDiffuse, AlbedoMapIsMonotonicAndKeepsItsEnds) {
  for (const double r : {0.0, 0.2, 0.7, 1.0}) {
    EXPECT_EQ(vmf_diffuse_albedo(0, r), 0);
    EXPECT_NEAR(vmf_diffuse_albedo(1, r), 1, 1e-15);
    double last = 0;
    for (double k = 0.05; k < 1; k += 0.05) {
      const double c = vmf_diffuse_albedo(k, r);
      EXPECT_GT(c, last);
      last = c;
    }
  }
  EXPECT_EQ(vmf_diffuse_albedo(0.3, 0), 0.3);
  // the printed form of the formula, where it does not cancel
  const double k = 0.4, s = 0.64985 + 0.631112 * 0.5 + 1.38922 * 0.25;
  const double root = (-1 + k + std::sqrt(1 - 2 * k + k * k + 4 * s * s * k * k)) / (2 * s * k);
  EXPECT_NEAR(vmf_diffuse_albedo(k, 0.5), root * std::sqrt(0.5) + (1 - std::sqrt(0.5)) * k, 1e-15);
}

TEST(VmfDiffuse, AppliesToVerticalLambertianFlakesOnly) {
  const ModelInfo& info = *find_model("vmf_diffuse");
  const auto p = info.applies_to(vmf_half_space(0.25));
  ASSERT_TRUE(p);
  EXPECT_EQ(p->number("roughness"), 0.25);
  const std::string vmf = "[[layer]]\nmedium = \"vmf_flake\"\nthickness = inf\n";
  const auto by_alpha = info.applies_to(parse_stack(vmf + "alpha = 0.6931471805599453\n", "", ""));
  ASSERT_TRUE(by_alpha);
  EXPECT_NEAR(by_alpha->number("roughness"), 0.25, 1e-15);
  const auto applies = [&](const std::string& keys) {
    return info.applies_to(parse_stack(vmf + keys, "", "")).has_value();
  };
  EXPECT_FALSE(applies("roughness = 0.5\naxis = [0, 1, 1]\n"));
  EXPECT_FALSE(applies("roughness = 0.5\nflake = \"mirror\"\n"));
}

}  // namespace
}  // namespace lamella
