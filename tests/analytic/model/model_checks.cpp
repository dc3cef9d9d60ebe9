#include "tests/analytic/model/model_checks.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/analytic/model/nested_quadrature.h"
#include "tests/statistics/statistics.h"

namespace lamella::testing {

std::unique_ptr<Model> make_model(
    const std::string& name, const std::vector<std::pair<std::string, ParameterValue>>& values) {
  const ModelInfo* info = find_model(name);
  if (!info) throw std::out_of_range("no model " + name);
  Parameters p;
  for (const auto& [key, value] : values)
    if (key == info->selector) p.set(key, value);
  const std::vector<ParameterInfo> infos = parameters_of(*info, p);
  for (const auto& [key, value] : values) p.set(key, checked(*find(infos, key), value));
  fill_defaults(infos, p);
  return info->make(p, nullptr);
}

double lane_error(double lobes, Direction wi, Direction wo) {
  const double mu = std::max({std::abs(wi.z), std::abs(wo.z), kGrazingLimit});
  return kLaneError * (lobes + 1 / (kPi * mu));
}

std::vector<Direction> probe_directions() {
  std::vector<Direction> list{{0, 0, 1}};
  for (const double mu : {0.97, 0.8, 0.5, 0.2, 0.02, 1e-7})
    for (const double phi : {0.0, 1.0, 2.5, 4.0}) list.push_back(direction_from_mu_phi(mu, phi));
  list.push_back(direction_from_degrees(90, 30));
  return list;
}

void expect_sane_values(const Model& model, int lobes, bool negative, double lane_errors) {
  const std::vector<Direction> list = probe_directions();
  std::vector<DirectionPair> pairs;
  for (const Direction wi : list)
    for (const Direction wo : list)
      if (wi.z > 0 || wo.z > 0) pairs.push_back({wi, wo});
  std::vector<std::vector<Rgb>> batches;
  for (const Isa isa : supported_isas()) model.eval(pairs, batches.emplace_back(pairs.size()), isa);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto [wi, wo] = pairs[k];
    const Rgb f = model.eval(wi, wo);
    Rgb sum, magnitude;
    for (int lobe = 0; lobe < lobes; ++lobe) {
      const Rgb part = model.eval_lobe(lobe, wi, wo);
      sum += part;
      for (int c = 0; c < 3; ++c) {
        magnitude[c] += std::abs(part[c]);
        EXPECT_TRUE(negative || part[c] >= 0) << lobe << ' ' << wi.z << ' ' << wo.z;
      }
    }
    for (int c = 0; c < 3; ++c) {
      EXPECT_TRUE(std::isfinite(f[c])) << wi.z << ' ' << wo.z;
      EXPECT_NEAR(sum[c], f[c], 1e-13 * (magnitude[c] + 1e-3)) << wi.z << ' ' << wo.z;
      for (std::size_t isa = 0; isa < batches.size(); ++isa)
        EXPECT_NEAR(batches[isa][k][c], f[c],
                    isa ? lane_errors * lane_error(magnitude[c], wi, wo) : 0)
            << to_text(supported_isas()[isa]) << ' ' << wi.z << ' ' << wo.z;
    }
    EXPECT_TRUE(wo.z == 0 || model.eval(wi, -wo) == Rgb(0)) << wi.z << ' ' << wo.z;
  }
}

void expect_reciprocal(const Model& model, double tolerance) {
  const std::vector<Direction> list = probe_directions();
  for (const Direction wi : list)
    for (const Direction wo : list) {
      if (wi.z == 0 && wo.z == 0) continue;
      const Rgb f = model.eval(wi, wo), g = model.eval(wo, wi);
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(f[c], g[c], tolerance * std::abs(f[c])) << wi.z << ' ' << wo.z;
    }
}

void expect_sampler_follows_its_pdf(const std::string& name, const Model& model,
                                    double pdf_tolerance) {
  for (const double theta : {0.0, 60.0, 89.0, 90.0}) {
    const Direction wo = direction_from_degrees(theta, 40);
    const auto pdf = [&](Direction wi) { return model.pdf(wi, wo); };
    EXPECT_NEAR(integrate_sphere(pdf, Direction{0, 0, 1}), 1, pdf_tolerance) << theta;
    const auto sample = [&](RandomStream& stream) {
      const double u1 = stream.uniform(), u2 = stream.uniform(), u3 = stream.uniform();
      const auto wi = model.sample(wo, u1, u2, u3);
      if (!wi) throw std::logic_error("a sampler without a sample");
      return *wi;
    };
    EXPECT_GT(sampler_p_value(name, Direction{0, 0, 1}, sample, pdf, 100000), test_level())
        << theta;
  }
}

void expect_albedo_equals_quadrature(const Model& model, double tolerance) {
  for (const double mu : {1.0, 0.7, 0.03}) {
    const Direction wi = direction_from_mu_phi(mu, 0.3);
    const Rgb integral =
        integrate_projected_rgb([&](Direction wo) { return model.eval(wi, wo); }, 1, 1e-8);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(model.albedo(wi)[c], integral[c], tolerance) << mu;
  }
}

}  // namespace lamella::testing
