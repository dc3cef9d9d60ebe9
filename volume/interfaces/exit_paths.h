#pragma once

#include <cstdint>
#include <vector>

#include "phase/random/random.h"
#include "volume/interfaces/boundary_stack.h"

namespace lamella {

/// Ways by which light leaves a stack with interfaces along asked-for directions, found from the
/// outside in: from each target w_o a ray enters, meets boundaries as light would (Snell at smooth
/// ones; a sampled facet at rough ones; at inner boundaries reflection or refraction by chance),
/// and every layer that it crosses has a segment of the way. An event in a layer sends light along
/// each segment that crosses its depth; that is next-event estimation through interfaces, with all
/// that interfaces still do to the light included.
///
/// A segment carries the light's direction w in its layer and what radiance along w at the end of
/// the segment makes of radiance along w_o: Fresnel's shares, attenuation beyond the layer, and
/// (n_o / n)^2, by reciprocity of the boundaries.
class ExitPaths {
 public:
  /// Segments in one layer, structure of arrays.
  struct Segments {
    std::vector<double> x, y, z;  ///< direction of the light
    std::vector<double> through;  ///< radiance that leaves / radiance at the segment's end
    std::vector<double> rate;     ///< optical depth per depth: sigma(-w) / |w.z|
    std::vector<int> target;
    [[nodiscard]] std::size_t count() const { return x.size(); }
  };
  /// Ways that begin at the substrate: rate has no meaning.
  using Ends = Segments;

  explicit ExitPaths(const BoundaryStack& stack) : stack_(stack), layers_(stack.layers.size()) {}

  void clear();
  /// Adds the ways to a target; w_o unit, mu != 0.
  void trace(Direction wo, int target, RandomStream& stream);

  [[nodiscard]] const Segments& in_layer(int layer) const { return layers_[layer]; }
  [[nodiscard]] const Ends& at_substrate() const { return substrate_; }
  /// Whether a random number was used since clear(): then every walk wants ways of its own.
  [[nodiscard]] bool is_random() const { return random_; }

 private:
  const BoundaryStack& stack_;
  std::vector<Segments> layers_;
  Ends substrate_;
  bool random_ = false;
};

}  // namespace lamella
