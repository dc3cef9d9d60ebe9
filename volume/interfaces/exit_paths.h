#pragma once

#include <array>
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
/// (n_o / n)^2, by reciprocity of the boundaries. A way that meets a mirror as substrate goes on
/// upwards, if ways are to be mirrored.
class ExitPaths {
 public:
  /// Segments in one layer, structure of arrays.
  struct Segments {
    std::vector<double> x, y, z;  ///< direction of the light
    std::vector<double> through;  ///< radiance that leaves / radiance at the segment's end
    std::vector<double> rate;     ///< optical depth per depth: sigma(-w) / |w.z|
    std::vector<int> target;
    /// If ways are mirrored, else empty: how often a mirror is met, each time as one more order,
    /// and what of the light it leaves in each channel.
    std::vector<std::uint64_t> mirrors;
    std::vector<std::array<double, 3>> mirrored;
    [[nodiscard]] std::size_t count() const { return x.size(); }
  };
  /// Ways that begin at the substrate: rate has no meaning.
  using Ends = Segments;

  /// mirrors: whether ways are mirrored at the substrate, if it is a mirror.
  explicit ExitPaths(const BoundaryStack& stack, bool mirrors = false)
      : stack_(stack),
        mirrors_(mirrors && stack.law && stack.law->is_delta()),
        layers_(stack.layers.size()) {}

  void clear();
  /// Adds the ways to a target; w_o unit, mu != 0.
  void trace(Direction wo, int target, RandomStream& stream);

  [[nodiscard]] const Segments& in_layer(int layer) const { return layers_[layer]; }
  [[nodiscard]] const Ends& at_substrate() const { return substrate_; }
  /// Whether a random number was used since clear(): then every walk wants ways of its own.
  [[nodiscard]] bool is_random() const { return random_; }

 private:
  struct Way {
    Direction w;  ///< of the light: the ray from the outside travels along -w
    double through = 1;
    std::uint64_t mirrors = 0;
    std::array<double, 3> mirrored{1, 1, 1};
  };
  void add(Segments& to, const Way& way, double rate, int target) const;
  /// Whether anything of the light on the way is left by the mirror.
  [[nodiscard]] bool mirror(Way& way, RandomStream& stream) const;

  const BoundaryStack& stack_;
  bool mirrors_;
  std::vector<Segments> layers_;
  Ends substrate_;
  bool random_ = false;
};

}  // namespace lamella
