#pragma once

namespace lamella {

/// The ranges of the parameters of a layer over which SpongeCake's network is trained and its
/// accuracy is measured. The paper names the parameters that it draws and not their ranges; these
/// hold every flake layer of its table 2 but two that are thinner (0.002 and a map).
/// Roughness, thickness times density, albedo and f0 per channel; dimensionless.
struct SpongecakeRanges {
  static constexpr double kRoughness[2] = {0.05, 1};
  static constexpr double kDepth[2] = {0.02, 10};
  static constexpr double kAlbedo[2] = {0.05, 1};
  static constexpr double kF0[2] = {0.02, 1};
};

}  // namespace lamella
