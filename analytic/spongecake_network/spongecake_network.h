#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "phase/math/color.h"
#include "phase/math/direction.h"

namespace lamella {

/// The networks that are part of the program are for 1 to this many layers.
inline constexpr int kNetworkLayers = 2;

/// A layer of SGGX mirror flakes as the network reads it, and the same layer of the second lobe as
/// it predicts it. Dimensionless; depth is thickness times density.
struct NetworkLayer {
  bool fiber = false;
  double roughness = 1;  ///< alpha
  Direction axis{};      ///< unit: normal of surfaces, direction of fibers; its sign has no meaning
  double depth = 1;
  Rgb albedo{1}, f0{1};
};

/// The lobes that stand for orders 2 and up.
struct PredictedLobes {
  std::array<NetworkLayer, kNetworkLayers> layers{};  ///< of the second lobe, whose weight W1 is 1
  Rgb reflect, transmit;  ///< albedos of the constant lobe, W2, per side
};

/// A perceptron with three hidden layers of 128 that maps the layers of a stack to SpongeCake's two
/// further lobes (Wang et al. 2022, section 5), by the weights that train.py wrote. It is evaluated
/// once per colour channel: grey stacks have grey lobes. Kind and axis of a layer stay as they are.
///
/// Beside the paper's inputs, which are absolute, its numbers are changes of the layers' own: all 0
/// means the single scattering itself. Axes come in by what a turn about z and their sign leave as
/// it is.
class SpongecakeNetwork {
 public:
  static constexpr int kHidden = 128;

  /// `weights`: the bytes of a file of train.py: "LMSC", version 1, layers (1 or 2), per step rows,
  /// columns, weights row by row, biases, all in little-endian float32; CRC-32 of what is before.
  /// Throws std::invalid_argument, with the reason, for anything else.
  explicit SpongecakeNetwork(std::string_view weights);

  [[nodiscard]] int layers() const { return layers_; }
  /// The lobes of a stack of layers() layers; any number of threads at once, without allocating.
  [[nodiscard]] PredictedLobes predict(std::span<const NetworkLayer> layers) const;

 private:
  struct Step {
    int rows = 0, columns = 0;
    std::vector<float> weight, bias;  // [row][column], [row]
  };

  int layers_ = 0;
  std::vector<Step> steps_;
};

/// The network for stacks of 1 to kNetworkLayers layers. Throws std::invalid_argument for others.
[[nodiscard]] const SpongecakeNetwork& spongecake_network(int layers);

/// The bytes of its weights.
[[nodiscard]] std::string_view spongecake_weights(int layers);

}  // namespace lamella
