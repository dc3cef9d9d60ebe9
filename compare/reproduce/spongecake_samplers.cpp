#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analytic/model/model.h"
#include "compare/judge/sampler_statistics.h"
#include "compare/reproduce/lit_spheres.h"
#include "compare/reproduce/number_rows.h"
#include "compare/reproduce/spongecake_figures.h"
#include "volume/run/simulation.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// A model that is sampled by the cosine law on either side, half of the samples each.
class CosineSampled final : public Model {
 public:
  explicit CosineSampled(const Model& model) : Model(2), model_(model) {}

  using Model::eval;
  [[nodiscard]] Rgb eval(Direction wi, Direction wo) const override { return model_.eval(wi, wo); }
  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    return model_.eval_lobe(lobe, wi, wo);
  }
  [[nodiscard]] std::optional<Direction> sample(Direction, double u1, double u2,
                                                double u3) const override {
    const Direction w = direction_from_mu_phi(std::sqrt(u2), 2 * kPi * u3);
    return Direction{w.x, w.y, u1 < 0.5 ? w.z : -w.z};
  }
  [[nodiscard]] double pdf(Direction wi, Direction) const override {
    return std::abs(wi.z) / (2 * kPi);
  }

 private:
  const Model& model_;
};

}  // namespace

Json reproduce_spongecake_figure_7(ReproductionContext& context) {
  struct FlakeLayer {
    const char* shape;
    double roughness;
  };
  const std::vector<FlakeLayer> layers{
      {"surface", 0.1}, {"surface", 0.5}, {"fiber", 0.1}, {"fiber", 0.5}};
  const std::vector<double> angles{20, 60};
  const auto cases = static_cast<std::uint64_t>(layers.size() * angles.size());
  const std::uint64_t samples = std::max<std::uint64_t>(100, context.walks / (2 * cases));
  const std::uint64_t walks = std::max<std::uint64_t>(kBatches, context.walks / (2 * cases));
  NumberRows rows(context, {{"shape", "", "", 8},
                            {"roughness", "g"},
                            {"theta", "g"},
                            {"walks", ".5f"},
                            {"walks_error", ".1e", "+-"},
                            {"bsdf", ".5f", "sampled"},
                            {"bsdf_error", ".1e", "+-"},
                            {"z", "+.2f"},
                            {"bsdf_variance", ".3e", "variance"},
                            {"cosine_variance", ".3e", "cosine's"}});
  rows.header(
      "one layer of SGGX mirrors, thickness 1: energy of order 1, reflected and transmitted, by "
      "walks and by the\nmodel's samples; variances of the sample's weight, of the model's sampler "
      "and of the cosine law");
  double largest = 0;
  int better = 0;
  for (const FlakeLayer& layer : layers)
    for (const double theta : angles) {
      if (is_set(context.stop)) return rows.rows();
      const Stack stack = figure_stack(
          "layer",
          fmt::format("[[layer]]\nmedium = \"sggx\"\nshape = \"{}\"\naxis = [{}]\nroughness "
                      "= {}\nthickness = 1\n",
                      layer.shape, layer.shape[0] == 'f' ? "1, 0, 0" : "0, 0, 1", layer.roughness));
      const Direction w = direction_from_degrees(theta, 0);
      Simulation simulation(stack, make_plan(stack, {.max_order = 1}), w, Estimator::analog,
                            CellGrid{2, 4, false}, context.seed);
      run(simulation, {.walks = walks, .target_error = {}, .seconds = {}}, {}, context.stop);
      const RunResult result = reduce(simulation);
      const Estimate up = result.reflected.orders[0][0], down = result.transmitted.orders[0][0];
      const double walked = up.value + down.value;
      // As of independent estimates: the two sides never gain together.
      const double walked_error = std::hypot(up.standard_error, down.standard_error);
      const BoundModel model = figure_model("single_scattering", &stack);
      const SamplerStatistics own = sampler_statistics(*model.model, w, samples, context.seed);
      const SamplerStatistics cosine =
          sampler_statistics(CosineSampled(*model.model), w, samples, context.seed);
      const double z = (own.mean - walked) / std::hypot(own.mean_error, walked_error);
      rows.add({layer.shape, layer.roughness, theta, walked, walked_error, own.mean, own.mean_error,
                z, own.variance, cosine.variance});
      largest = std::max(largest, std::abs(z));
      better += own.variance < cosine.variance;
    }
  context.find("analytic single scattering and its Monte Carlo simulation give identical results",
               fmt::format("the energies differ by at most {:.1f} standard errors", largest),
               largest < 4);
  context.find(
      "sampling the BSDF suits narrow lobes",
      fmt::format("its variance is below the cosine law's in {} of {} cases", better, cases),
      2 * better > static_cast<int>(cases));
  return rows.rows();
}

}  // namespace lamella
