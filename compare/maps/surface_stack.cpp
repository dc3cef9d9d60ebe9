#include "compare/maps/surface_stack.h"

#include <fmt/format.h>

#include <algorithm>

#include "compare/request/substrate_model.h"
#include "phase/random/random.h"

namespace lamella {

SurfaceStack::SurfaceStack(MappedStack stack) : stack_(std::move(stack)) {
  for (const MappedKey& key : stack_.maps()) maps_.emplace_back(key);
}

std::string SurfaceStack::told() const {
  const MappedKey& first = stack_.maps().front();
  return fmt::format("{}: found the picture \"{}\"", first.where, first.map.file);
}

std::vector<std::filesystem::path> SurfaceStack::files() const {
  std::vector<std::filesystem::path> files;
  for (const ValueMap& map : maps_)
    if (std::find(files.begin(), files.end(), map.file()) == files.end())
      files.push_back(map.file());
  return files;
}

int SurfaceStack::columns() const {
  int most = 1;
  for (const ValueMap& map : maps_) most = std::max(most, map.columns());
  return most;
}

int SurfaceStack::rows() const {
  int most = 1;
  for (const ValueMap& map : maps_) most = std::max(most, map.rows());
  return most;
}

Stack SurfaceStack::at(double u, double v) const { return with(values(u, v)); }

std::vector<ParameterValue> SurfaceStack::values(double u, double v) const {
  std::vector<ParameterValue> values;
  for (const ValueMap& map : maps_) values.push_back(map.at(u, v));
  return values;
}

Stack SurfaceStack::with(const std::vector<ParameterValue>& values) const {
  return with_surface_model(stack_.with(values));
}

std::vector<std::string> SurfaceStack::paths() const {
  std::vector<std::string> paths;
  for (const MappedKey& key : stack_.maps()) paths.push_back(key.path());
  return paths;
}

std::vector<Stack> SurfaceStack::texels(std::uint64_t seed) const {
  // Texel k and k + kBatches lie in the lower and the upper half of the map, at the same column.
  std::vector<Stack> stacks;
  for (int k = 0; k < kTexelSide * kTexelSide; ++k) {
    const int column = k % kTexelSide, row = k / kTexelSide;
    RandomStream stream(seed, static_cast<std::uint64_t>(k), StreamPurpose::measure);
    const double u = (column + stream.uniform()) / kTexelSide;
    const double v = (row + stream.uniform()) / kTexelSide;
    stacks.push_back(at(u, v));
  }
  return stacks;
}

}  // namespace lamella
