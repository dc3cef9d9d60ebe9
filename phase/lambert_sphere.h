#pragma once

#include "phase/lambert_sphere_formula.h"
#include "phase/phase_function.h"
#include "phase/sampling.h"

namespace lamella {

/// lambert_sphere_phase_of in double.
[[nodiscard]] inline double lambert_sphere_phase(double cosine) {
  return lambert_sphere_phase_of(cosine);
}

/// Exact sample of the deflection cosine from three uniforms in [0, 1) (d'Eon 2021, eq. 6, with
/// sin(pi (u3 - 1/2)) for sin(2 pi u3), which has the same distribution and a shorter series).
template <class Real>
[[nodiscard]] Real lambert_sphere_cosine(Real u1, Real u2, Real u3) {
  using std::sqrt;
  const auto [s, c] = sine_cosine_near_zero((u3 - Real(0.5)) * Real(kPi / 2));
  return sqrt((Real(1) - u1) * (Real(1) - u2)) * (Real(2) * s * c) - sqrt(u1 * u2);
}

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
};

}  // namespace lamella
