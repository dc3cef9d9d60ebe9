#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "phase/interface/dielectric.h"
#include "phase/stack/stack.h"
#include "volume/plan/plan.h"
#include "volume/walk/walk.h"

namespace lamella {

/// A stack with interfaces as walks see it: layers 0 to n - 1 from the top, boundary k above layer
/// k, boundary n below the last one. A boundary without an interface lets light pass. Where two
/// interfaces meet, or one meets the substrate, an empty layer of depth 0 lies between them.
struct BoundaryStack {
  BoundaryStack(const Stack& stack, const Plan& plan);

  std::vector<WalkLayer> layers;
  std::vector<int> sources;  ///< per layer, which of the stack's it is; -1: an empty one
  std::vector<std::optional<Dielectric>> boundaries;  ///< n + 1
  bool has_substrate = false;
  std::array<double, 3> substrate_albedo{};  ///< of Lambert's law, where there is no other
  std::shared_ptr<const SurfaceLaw> law;     ///< of the substrate, or nullptr
  std::uint64_t max_order = 0;
  Thinning thinning;

  [[nodiscard]] int count() const { return static_cast<int>(layers.size()); }
  /// Whether light that travels along -w in the layer is totally reflected at both of its
  /// boundaries, both smooth: it would never leave without an event.
  [[nodiscard]] bool is_trapped(int layer, Direction w) const;
};

}  // namespace lamella
