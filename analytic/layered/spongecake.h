#pragma once

#include <span>
#include <string>
#include <vector>

#include "analytic/model/model.h"

namespace lamella {

/// SpongeCake: the generic single scattering of a stack whose layers are all SGGX mirror flakes or
/// Henyey-Greenstein particles, with the paper's importance sampling, and the two lobes that stand
/// for multiple scattering, orders 2 and up (section 5): a second single-scattering lobe of the
/// same layers, kinds and axes with other roughness, depth, albedo and f0, times a weight (W1), and
/// a constant lobe (W2, an albedo per side and channel). Their parameters are, by the key `lobes`,
///   network   predicted by the network of spongecake_network (why_no_network says where)
///   fit       those that `lamella fit` finds (compare/fit/fitted_models.h)
///   given     the keys; none: neither lobe
///   auto      given if there is a key of a lobe; else network where it applies; else fit.
/// This model knows no truth: with fit, and with auto where the network does not apply, it takes
/// the keys as they are, 0 where none are given. Roughness (of a Henyey-Greenstein layer, g),
/// depth, albedo and f0 are given as factors of the layer's own. Reciprocal. Lobes `single`,
/// `substrate`, `second`, `lambert`. Sampling is that of single scattering alone, as in the paper.
/// Wang et al. 2022, "SpongeCake: A Layered Microflake Surface Appearance Model", sections 4, 5.
[[nodiscard]] ModelInfo spongecake_model();

/// Whether SpongeCake describes the stack.
[[nodiscard]] bool is_spongecake_stack(const Stack& stack);

/// Layers that have factors of their own; those below share the last one's, but for f0.
inline constexpr int kSpongecakeLayers = 8;

/// The layers of the second lobe: factor[k] on layer k's roughness or g (no more than the range of
/// the key allows), on its depth, on its albedo (linear in the lobe: it may exceed 1) and on its f0
/// (of flakes; the product is 1 at most). No substrate. Throws ParameterError where a layer without
/// roughness gets a factor but 1.
struct SpongecakeFactors {
  double roughness = 1, depth = 1;
  Rgb albedo{1}, f0{1};
};
[[nodiscard]] Stack spongecake_second_stack(const Stack& stack,
                                            std::span<const SpongecakeFactors> factors);

/// The lobes of multiple scattering: factors of the second lobe, whose weight W1 is 1, and the
/// albedos of the constant lobe, W2, per side.
struct SpongecakeLobes {
  std::vector<SpongecakeFactors> factors;
  Rgb reflect, transmit;
};

/// Why the network does not describe the stack; empty where it does: one or two layers of
/// SGGX mirror flakes given by shape and roughness, no substrate, every number within
/// SpongecakeRanges.
[[nodiscard]] std::string why_no_network(const Stack& stack);
/// What the network predicts. Throws ParameterError where why_no_network has a reason.
[[nodiscard]] SpongecakeLobes predicted_lobes(const Stack& stack);

}  // namespace lamella
