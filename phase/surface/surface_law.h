#pragma once

#include <optional>

#include "phase/math/color.h"
#include "phase/math/direction.h"
#include "phase/math/vec3.h"
#include "phase/random/random.h"

namespace lamella {

/// How an opaque surface with the normal z reflects, where Lambert's law is not enough: a
/// conductor, or a closed form as walks see it. Directions are unit and point away from the
/// surface, z > 0. Implementations are immutable and may be called from any thread.
class SurfaceLaw {
 public:
  struct Sample {
    Direction wo;
    Rgb weight;  ///< f(w_i, w_o) mu_o over the density of w_o: its mean is the directional albedo
    /// The light that the law neither reflects nor absorbs, in the shadow of single scattering. It
    /// is `lost` in the ledger; the rest, 1 - weight - lost, is absorbed.
    Rgb lost{};
  };

  virtual ~SurfaceLaw() = default;
  /// f(w_i, w_o) [1/sr], the BSDF without the cosine; where is_stochastic(), an estimate whose mean
  /// is f. Not of a delta.
  [[nodiscard]] virtual Rgb eval(Direction wi, Direction wo, RandomStream& stream) const = 0;
  /// A direction for light that arrived from w_i, or nothing: then the light is absorbed.
  [[nodiscard]] virtual std::optional<Sample> sample(Direction wi, RandomStream& stream) const = 0;
  /// The density [1/sr] with which sample(w_i) gives w_o, or a number that rises and falls with it:
  /// a weight between two ways to find the same light, which need not be exact.
  [[nodiscard]] virtual double density(Direction, Direction wo) const { return wo.z / kPi; }
  /// Whether w_o is the mirror image of w_i and no other.
  [[nodiscard]] virtual bool is_delta() const { return false; }
  /// Whether eval() is an estimate rather than f itself.
  [[nodiscard]] virtual bool is_stochastic() const { return false; }
  /// Whether the law has no other direction than z: f depends on the azimuths' difference alone.
  [[nodiscard]] virtual bool is_symmetric_about_z() const { return true; }
};

}  // namespace lamella
