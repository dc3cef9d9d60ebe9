#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "compare/nearest/nearest_models.h"
#include "phase/stack/stack.h"

namespace lamella {

/// The roughness of what can stand for explicit geometry, by lobes: fits to walks among its grains.
struct GrainFit {
  Stack equivalent;  ///< as the normals were measured
  TargetTruths target;
  NearestModels by_normals;  ///< what that leaves over, nothing free
  NearestModels medium;      ///< the same medium, its roughness free
  /// `vmf_diffuse` of the grains' albedo, its roughness free: of Lambertian grains that pass no
  /// light.
  std::optional<NearestModels> form{};
};

/// Fits the roughness of an equivalent stack (volume/grains/grain_measure.h), a layer of vmf_flake
/// or sggx, to the lobes of the request's stack, and by what its closed form comes nearest. The
/// density stays. Throws UsageError where the medium has no roughness, FitError without Ceres.
[[nodiscard]] GrainFit fit_grains(const TruthRequest& request, const Stack& equivalent,
                                  const RunMonitor& monitor);

/// A row per fit: the roughness, its errors as those of `fit`, and what is left over.
[[nodiscard]] std::string grain_fit_table(const GrainFit& fit);
/// The same: walks and incident directions, then an object per fit.
[[nodiscard]] nlohmann::ordered_json grain_fit_json(const GrainFit& fit);

}  // namespace lamella
