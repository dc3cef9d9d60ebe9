#pragma once

#include "phase/math/sampling.h"
#include "phase/medium/phase_function.h"

namespace lamella {

/// Reflection by Lambert's law at a white surface with a unit normal: of a flake whose normal has
/// been drawn, and of the substrate. Where the light came from does not matter.
struct LambertEvent {
  Direction normal;

  /// <w_o, n> / pi [1/sr].
  [[nodiscard]] PhaseValue density(Direction wo) const {
    return {std::fmax(0, dot(wo, normal)) / kPi, 0};
  }
  [[nodiscard]] Scatter sample(RandomStream& stream) const {
    const double u1 = stream.uniform(), u2 = stream.uniform();
    return {cosine_hemisphere(normal, u1, u2), 0};
  }
};

/// The event at a horizontal white Lambertian substrate.
inline constexpr LambertEvent kLambertSubstrate{{0, 0, 1}};

/// Radiance that a white Lambertian surface returns under that irradiance: its density over the
/// cosine.
[[nodiscard]] constexpr double lambert_radiance(double irradiance) { return irradiance / kPi; }

}  // namespace lamella
