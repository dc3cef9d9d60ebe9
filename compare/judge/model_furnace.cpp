#include "compare/judge/model_furnace.h"

#include <cmath>
#include <stdexcept>

#include "analytic/model/stochastic_model.h"

namespace lamella {
namespace {

constexpr double kNoiseLevel = 1e-3;

}  // namespace

ModelFurnace judge_model_furnace(const Model& model, Direction wi, bool as_is, double tolerance) {
  const Direction w = with_grazing_limit(wi);
  const AlbedoEstimate scattered = model.albedo_with_error(w);
  ModelFurnace furnace{.energy = scattered.value + model.specular(w) + Rgb(model.uncollided(w)),
                       .error = scattered.error,
                       .end = scattered.end};
  const bool estimated = dynamic_cast<const StochasticModel*>(&model) != nullptr;
  bool unknown = false;
  for (int c = 0; c < 3; ++c) {
    const double defect = furnace.energy[c] - 1;
    if (!std::isfinite(defect))
      throw std::domain_error("the model gives a value that is not finite");
    const double noise = (estimated ? furnace_quantile(kNoiseLevel) : 1) * furnace.error[c];
    const double off = as_is ? std::max(0.0, defect) : std::abs(defect);
    if (off > tolerance + noise) {
      furnace.gains = furnace.gains || defect > 0;
      furnace.loses = furnace.loses || defect < 0;
    }
    unknown = unknown || off + noise > tolerance;
  }
  furnace.verdict = furnace.loses || furnace.gains ? FurnaceVerdict::fail
                    : unknown                      ? FurnaceVerdict::inconclusive
                                                   : FurnaceVerdict::pass;
  return furnace;
}

}  // namespace lamella
