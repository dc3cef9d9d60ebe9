#pragma once

#include <optional>

#include "phase/math/color.h"
#include "phase/math/vec3.h"

namespace lamella {

/// How an opaque surface with the normal z reflects, where Lambert's law is not enough: a closed
/// form as walks see it. Directions are unit and point away from the surface, z > 0.
/// Implementations are immutable and may be called from any thread.
class SurfaceLaw {
 public:
  struct Sample {
    Direction wo;
    Rgb weight;  ///< f(w_i, w_o) mu_o over the density of w_o: its mean is the directional albedo
  };

  virtual ~SurfaceLaw() = default;
  /// f(w_i, w_o) [1/sr], the BSDF without the cosine.
  [[nodiscard]] virtual Rgb eval(Direction wi, Direction wo) const = 0;
  /// A direction for light that arrived from w_i, from three uniforms in (0, 1), or nothing: then
  /// the light is absorbed.
  [[nodiscard]] virtual std::optional<Sample> sample(Direction wi, double u1, double u2,
                                                     double u3) const = 0;
};

}  // namespace lamella
