#pragma once

#include <optional>

#include "phase/math/vec3.h"
#include "phase/parameters/parameters.h"

namespace lamella {

/// How a model draws w_i given w_o.
enum class HemisphereSampler {
  mis,     ///< cltc or uniform, one of them drawn: one-sample multiple importance sampling
  cltc,    ///< clipped linearly transformed cosine: nothing below the surface
  ltc,     ///< linearly transformed cosine: samples below the surface are lost
  cosine,  ///< density cos / pi
  uniform  ///< density 1 / (2 pi)
};

/// The parameter `sampler` of the models that have these five, mis by default.
[[nodiscard]] ParameterInfo sampler_parameter();
/// Its value.
[[nodiscard]] HemisphereSampler sampler_of(const Parameters& parameters);

/// The cosine lobe about the normal under w = M h / |M h|, M = [[a, 0, b], [0, c, 0], [d, 0, 1]],
/// in the frame in which w_o = (sin, 0, mu), with det M = c (a - b d) > 0. Clipped: h is drawn only
/// where M h lies above the surface, a half disc and half an ellipse of the projected hemisphere.
/// Portsmouth, Kutz and Hill 2025, "EON", section 3.1, with the clip on whichever side d has it;
/// Heitz et al. 2016, "Real-time polygonal-light shading with linearly transformed cosines".
struct ClippedCosine {
  double a = 1, b = 0, c = 1, d = 0;
  double uniform = 0;  ///< probability of the uniform hemisphere in HemisphereSampler::mis

  /// A direction in the frame of w_o from three uniforms in (0, 1). Only ltc goes below.
  [[nodiscard]] Direction sample(HemisphereSampler sampler, double u1, double u2, double u3) const;
  /// Density [1/sr] of a unit direction in the frame of w_o. It integrates to 1 over the upper
  /// hemisphere (ltc: over the sphere).
  [[nodiscard]] double pdf(HemisphereSampler sampler, Direction wi) const;
};

/// The frame around the normal in which w has azimuth 0.
[[nodiscard]] Frame<double> frame_towards(Direction w);

}  // namespace lamella
