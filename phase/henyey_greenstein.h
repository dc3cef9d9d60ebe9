#pragma once

#include "phase/phase_function.h"
#include "phase/sampling.h"

namespace lamella {

/// Henyey-Greenstein phase function [1/sr] by the cosine of the deflection; g in (-1, 1) is its
/// mean, g > 0 scatters forward, 0 is isotropic.
/// (1 - g^2) / (4 pi (1 + g^2 - 2 g cosine)^(3/2)), the base written without cancellation.
template <class Real>
[[nodiscard]] Real henyey_greenstein_phase(Real g, Real cosine) {
  using std::sqrt;
  // 1 + g^2 - 2 g cosine, written as (1 - |g|)^2 + 2 |g| (1 -+ cosine)
  const Real a = g < Real(0) ? -g : g;
  const Real c = g < Real(0) ? -cosine : cosine;
  const Real base = (Real(1) - a) * (Real(1) - a) + Real(2) * a * (Real(1) - c);
  return (Real(1) - g) * (Real(1) + g) / (Real(4 * kPi) * base * sqrt(base));
}

/// Exact sample of the deflection cosine from a uniform in (0, 1): the inverse of the cumulative
/// distribution, written so that g -> 0 needs no special case and rounding keeps it in [-1, 1].
template <class Real>
[[nodiscard]] Real henyey_greenstein_cosine(Real g, Real u) {
  const Real x = Real(2) * u - Real(1);
  // (1 + g^2 - ((1 - g^2) / (1 + g x))^2) / (2 g), with the division by g carried out
  const Real d = Real(1) + g * x;
  return (x * (Real(1) + g * g) + g / Real(2) * (x * x + Real(3) + g * g * (x * x - Real(1)))) /
         (d * d);
}

/// Particles with the Henyey-Greenstein phase function. sigma = 1.
struct HenyeyGreenstein {
  double g = 0;

  struct Event {
    double g;
    Direction wi;

    [[nodiscard]] PhaseValue density(Direction wo) const {
      return {henyey_greenstein_phase(g, -dot(wi, wo)), 0};
    }
    [[nodiscard]] Scatter sample(RandomStream& stream) const {
      const double cosine = henyey_greenstein_cosine(g, stream.uniform());
      return {deflect(-wi, cosine, stream.uniform()), 0};
    }
  };

  [[nodiscard]] double sigma(Direction) const { return 1; }
  [[nodiscard]] PhaseValue phase(Direction wi, Direction wo) const {
    return {henyey_greenstein_phase(g, -dot(wi, wo)), 0};
  }
  [[nodiscard]] Event collide(Direction wi, RandomStream&) const { return {g, wi}; }
  [[nodiscard]] bool is_delta() const { return false; }
};

}  // namespace lamella
