#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "compare/nearest/model_fit.h"
#include "compare/nearest/target_truths.h"

namespace lamella {

/// How far fits are from the truth along incident directions that they were not made on
/// (held_out.h): relative RMSE without noise, as FitNorm::relative has it. Empty: not asked for.
struct HeldOut {
  std::vector<Direction> directions;
  std::vector<double> relative_rmse;  ///< of each fit
};

/// Closed forms with the parameters that bring each nearest to a target, the nearest first.
struct NearestModels {
  FitNorm norm = FitNorm::relative;
  bool transmitted = false;  ///< whether the other side's lobes count, too
  std::vector<ModelFit> fits;
  std::vector<std::string> refused;  ///< models that had no values there, one line each
  bool interrupted = false;
  HeldOut held_out{};
};

/// The sides that count: both, or the reflected one.
enum class FitSides { all, reflect };

/// The models of requests (models_to_fit) for a target of 1 or 3 channels. Throws UsageError for a
/// model or a key that is unknown, a value that is not allowed, or a model that cannot be fitted:
/// cheap, before any work.
[[nodiscard]] std::vector<ParametricModel> parametric_models(
    const std::vector<ModelRequest>& requests, int channels);

/// Fits each model to the target. Throws UsageError where none has values.
[[nodiscard]] NearestModels nearest_models(const TargetTruths& target,
                                           const std::vector<ParametricModel>& models, FitNorm norm,
                                           FitSides sides, const RunMonitor& monitor);

/// The models as they came out, to be judged.
[[nodiscard]] std::vector<BoundModel> bound_models(const NearestModels& nearest);

/// Tables: the models in the order of their distance; then, of the first kToldModels, each
/// parameter with its uncertainty and what is left over per lobe.
[[nodiscard]] std::string fit_summary(const TargetTruths& target, const NearestModels& nearest);
inline constexpr std::size_t kToldModels = 4;

/// The answer of `fit` for models.
[[nodiscard]] nlohmann::ordered_json fit_json(const TargetTruths& target,
                                              const NearestModels& nearest);

}  // namespace lamella
