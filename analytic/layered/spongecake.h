#pragma once

#include "analytic/model/model.h"

namespace lamella {

/// SpongeCake: the generic single scattering of a stack whose layers are all SGGX mirror flakes or
/// Henyey-Greenstein particles, with the paper's importance sampling, and the two lobes that stand
/// for multiple scattering (section 5): a second single-scattering lobe of the same layers with
/// other roughness, depth and albedo, times a weight, and a constant lobe on either side. Their
/// parameters, which the paper leaves to a neural network, are the user's or, by default, those
/// that `lamella fit` finds (compare/fit/fitted_models.h); the model itself knows no truth and
/// takes keys as they are, 0 where none are given. lobes=none: neither lobe. Roughness (of a
/// Henyey-Greenstein layer, g), depth and albedo are given as factors of the layer's own, for up to
/// four layers. Reciprocal. Lobes `single`, `substrate`, `second`, `lambert`. Sampling is that of
/// single scattering alone, as in the paper. Wang et al. 2022, "SpongeCake: A Layered Microflake
/// Surface Appearance Model", sections 4, 5.
[[nodiscard]] ModelInfo spongecake_model();

/// Whether SpongeCake describes the stack.
[[nodiscard]] bool is_spongecake_stack(const Stack& stack);

/// Layers that have factors of their own.
inline constexpr int kSpongecakeLayers = 4;

/// The layers of the second lobe: factor[k] on layer k's roughness or g (no more than the range of
/// the key allows), on its depth and on its albedo (linear in the lobe: it may exceed 1). No
/// substrate. Throws ParameterError where a layer without roughness gets a factor but 1.
struct SpongecakeFactors {
  double roughness = 1, depth = 1;
  Rgb albedo{1};
};
[[nodiscard]] Stack spongecake_second_stack(const Stack& stack,
                                            std::span<const SpongecakeFactors> factors);

}  // namespace lamella
