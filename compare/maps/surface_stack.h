#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "compare/maps/value_map.h"
#include "phase/stack/mapped_stack.h"

namespace lamella {

/// Texels along either side of the sample that stands for a whole map.
inline constexpr int kTexelSide = 16;

/// A stack with its pictures: a plain stack at every place (u, v) of the surface.
class SurfaceStack {
 public:
  /// Reads the pictures. Throws StackFileError.
  explicit SurfaceStack(MappedStack stack);

  [[nodiscard]] const std::string& name() const { return stack_.name(); }
  [[nodiscard]] bool has_maps() const { return !maps_.empty(); }
  /// Of the first map: "wood.toml:5: layer 0: key \"albedo\": found the picture \"wood.exr\"".
  [[nodiscard]] std::string told() const;
  /// The pictures' files, each once.
  [[nodiscard]] std::vector<std::filesystem::path> files() const;
  /// Texels of the finest map along u and v; 1 without maps.
  [[nodiscard]] int columns() const;
  [[nodiscard]] int rows() const;

  /// The stack of a place, its surface model ready for walks. Throws StackFileError.
  [[nodiscard]] Stack at(double u, double v) const;
  /// The values of the maps' keys at a place, and the stack with such values.
  [[nodiscard]] std::vector<ParameterValue> values(double u, double v) const;
  [[nodiscard]] Stack with(const std::vector<ParameterValue>& values) const;
  /// The key of each map: "layer.0.albedo".
  [[nodiscard]] std::vector<std::string> paths() const;
  /// Stacks whose mean stands for the whole map: one in each of kTexelSide^2 equal squares, at
  /// random places of the seed, row by row from v = 0.
  [[nodiscard]] std::vector<Stack> texels(std::uint64_t seed) const;

 private:
  MappedStack stack_;
  std::vector<ValueMap> maps_;
};

}  // namespace lamella
