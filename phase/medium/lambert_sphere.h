#pragma once

#include "phase/medium/lambert_sphere_formulas.h"
#include "phase/medium/phase_function.h"

namespace lamella {

/// Probability that the deflection cosine is at most `cosine`:
/// 1 - (2 theta + theta cos 2 theta - 3/2 sin 2 theta) / (3 pi).
[[nodiscard]] double lambert_sphere_cdf(double cosine);

/// The fitted inverse of lambert_sphere_cdf from one uniform (d'Eon 2021, eq. 7): absolute error
/// below 5.8e-4.
[[nodiscard]] double lambert_sphere_cosine_fit(double u);

/// The inverse of lambert_sphere_cdf from one uniform in [0, 1], by bracketed Newton steps from the
/// fit: |cdf(result) - u| < 1e-14.
[[nodiscard]] double lambert_sphere_cosine_inverse(double u);

/// Particles that are opaque Lambertian spheres, far apart. sigma = 1.
struct LambertSphere {
  struct Event {
    Direction wi;

    [[nodiscard]] PhaseValue density(Direction wo) const {
      return {lambert_sphere_phase(-dot(wi, wo)), 0};
    }
    [[nodiscard]] Scatter sample(RandomStream& stream) const {
      const auto [u1, u2, u3, u4] = stream.four_uniforms();
      return {deflect(-wi, lambert_sphere_cosine(u1, u2, u3), u4), 0};
    }
  };

  [[nodiscard]] double sigma(Direction) const { return 1; }
  [[nodiscard]] PhaseValue phase(Direction wi, Direction wo) const {
    return {lambert_sphere_phase(-dot(wi, wo)), 0};
  }
  [[nodiscard]] Event collide(Direction wi, RandomStream&) const { return {wi}; }
  [[nodiscard]] bool is_delta() const { return false; }
  [[nodiscard]] MediumTraits traits() const {
    return {.two_sided = true,
            .symmetric_about_z = true,
            .has_axis = false,
            .mean_normal = Direction{0, 0, 0},
            .shape = PhaseShape::smooth,
            .mean_cosine = 0};
  }
  /// 2 / (3 pi) [1/sr] straight back, below 1.
  [[nodiscard]] double largest_density() const { return 1; }

  friend bool operator==(const LambertSphere&, const LambertSphere&) = default;
};

}  // namespace lamella
