#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "compare/judge/check_line.h"
#include "compare/judge/sampler_checks.h"

namespace lamella {

/// A model of the battery: made when its turn comes.
struct CheckConfiguration {
  std::string request;  ///< as --model takes it
  /// The model, or nothing where these parameters are refused together.
  std::function<std::shared_ptr<const Model>()> make;
};

struct ModelCheckSettings {
  int lobes = 1;
  bool reciprocal = true, transmits = false;  ///< as the model claims
  std::uint64_t samples = 20000;              ///< of the sampler, per direction and configuration
  std::uint64_t seed = 1;
  double seconds = 60;      ///< after which no further case is begun
  bool few_angles = false;  ///< 0, 60 and 90 degrees, in the place of 0, 30, 60, 80, 89 and 90
  std::function<bool()> stop{};
};

struct ModelCheck {
  std::vector<CheckLine> lines;
  SamplerExtremes extremes{};
  int configurations = 0;  ///< done, as far as the time allowed
  int refused = 0;         ///< whose parameters the model refuses
  bool ended_by_time = false;
  std::uint64_t samples = 0;  ///< per direction; fewer than asked for where values are slow
  bool single_precision = false;

  [[nodiscard]] bool failed() const;
};

/// The battery of checks of a closed form: values, reciprocity, batches, energy, albedo, density,
/// samples, weights, each over all configurations. Energy: light that leaves is at most 1 within
/// kFurnaceTolerance (judge_model_furnace). Statistical cases share a false-alarm probability of
/// 1e-3 (Sidak); equal seeds give equal answers, unless time ends the battery or a value takes so
/// long that fewer samples are drawn. Values that are refused (std::domain_error) are failures;
/// other exceptions pass.
[[nodiscard]] ModelCheck check_model(const std::vector<CheckConfiguration>& configurations,
                                     const ModelCheckSettings& settings);

/// Energy above 1 that passes, as in the furnace of closed forms.
inline constexpr double kFurnaceTolerance = 1e-3;

}  // namespace lamella
