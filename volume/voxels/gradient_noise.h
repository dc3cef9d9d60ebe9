#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace lamella {

/// Gradient noise on a lattice that repeats after `cells` cells along each axis (Perlin 2002,
/// "Improving noise", with random unit gradients instead of his twelve): mean 0, smooth to the
/// second derivative, about within [-1, 1].
class GradientNoise {
 public:
  GradientNoise(std::array<int, 3> cells, std::uint64_t seed);

  /// x, y, z in lattice cells, any number.
  [[nodiscard]] double operator()(double x, double y, double z) const;

 private:
  std::array<int, 3> cells_;
  std::vector<std::array<double, 3>> gradients_;
};

}  // namespace lamella
