#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "compare/ensemble/multiple_lobes.h"

namespace lamella {

/// A data set of random SpongeCake stacks with their orders 2 and up, for training: what it holds.
struct LobeDatasetPlan {
  int layers = 1;
  std::uint64_t stacks = 4000, walks = 32768, seed = 1;  ///< walks: per direction
  int directions = 8;                                    ///< per stack
  CellGrid grid{8, 16, false};

  /// Stacks of a file.
  static constexpr std::uint64_t kBlock = 50;
  [[nodiscard]] std::uint64_t blocks() const { return (stacks + kBlock - 1) / kBlock; }
};

/// A stack of the set and its truth.
struct LobeDatum {
  Stack stack;
  MultipleLobes lobes;
};
[[nodiscard]] LobeDatum lobe_datum(const LobeDatasetPlan& plan, std::uint64_t number);

/// "block_00012.npz"
[[nodiscard]] std::string block_name(std::uint64_t block);

/// The bytes of a NumPy archive of n stacks with L layers and d directions, in float32 but for the
/// number:
///   number [n] uint64          of the stack in the ensemble
///   parameters [n, L, 12]      roughness, albedo r g b, thickness, f0 r g b, kind (0 surface, 1
///                              fiber), axis x y z; layers from the top
///   w_i [n, d, 3]              unit vectors to the light
///   f [n, d, 2, mu, phi, 3]    orders 2 and up [1/sr] on cells: side (that of the light first),
///                              equal steps of mu^2 from the normal, azimuth relative to w_i
///   noise [n]                  root mean square of the standard errors over that of f
/// Equal data give equal bytes.
[[nodiscard]] std::string lobe_block(const std::vector<LobeDatum>& data, std::uint64_t first);

}  // namespace lamella
