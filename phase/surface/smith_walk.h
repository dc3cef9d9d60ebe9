#pragma once

#include <cmath>

#include "phase/math/vec3.h"
#include "phase/surface/microfacet.h"

namespace lamella {

/// Light between the facets of a Smith surface (Heitz et al. 2016, "Multiple-scattering microfacet
/// BSDFs with the Smith model"), in the coordinate s = -ln C(h), C the distribution of the heights:
/// an exponential medium of facets with density 1, deeper with growing s. A ray along d shows
/// facets to -d; per step in s it meets area(-d) / |d.z| of them. Above and below the surface the
/// heights are counted from the other side: s of one side is -ln(1 - exp(-s)) of the other.
/// Frames: z points away from the surface on the side where the light is.
struct SmithRay {
  bool above = true;  ///< on the side that z of the stack points to
  double s = 0;       ///< depth among the facets, in [0, infinity]
  Direction back{};   ///< unit, back to where the light comes from, in the frame of its side

  /// The same depth counted from the other side, -ln(1 - exp(-s)): finite for every s > 0, as light
  /// that arrives at grazing meets its first facet at s next to 0.
  [[nodiscard]] static double other_side(double s) {
    return s < 0.5 ? -std::log(-std::expm1(-s)) : -std::log1p(-std::exp(-s));
  }
  /// The direction in the frame of the other side, or of the stack for a ray below.
  [[nodiscard]] static Direction turned(Direction w) { return {w.x, w.y, -w.z}; }

  /// Light that comes from w, in the frame of the stack, at the first facet that it meets.
  template <class Stream>
  [[nodiscard]] static SmithRay arriving(const Facets& facets, Direction w, Stream& stream) {
    SmithRay ray{.above = w.z > 0, .s = 0, .back = w.z > 0 ? w : turned(w)};
    ray.s = stream.exponential() * ray.back.z / facets.area(ray.back);
    return ray;
  }

  /// Flies along d, unit, in the frame of its side: true if the ray leaves the surface.
  template <class Stream>
  [[nodiscard]] bool flies(const Facets& facets, Direction d, Stream& stream) {
    s -= stream.exponential() * d.z / facets.area(-d);
    back = -d;
    return !(s > 0);
  }

  /// The share of light that leaves along w (same side, w.z > 0) from where the ray is.
  [[nodiscard]] double escapes(const Facets& facets, Direction w) const {
    return w.z > 0 ? std::exp(-s * facets.area(-w) / w.z) : 0;
  }
};

}  // namespace lamella
