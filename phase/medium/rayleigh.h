#pragma once

#include "phase/medium/phase_function.h"
#include "phase/medium/rayleigh_formulas.h"

namespace lamella {

/// Particles much smaller than the wavelength: Rayleigh's phase function, without polarisation.
/// sigma = 1.
struct Rayleigh {
  struct Event {
    Direction wi;

    [[nodiscard]] PhaseValue density(Direction wo) const {
      return {rayleigh_phase(-dot(wi, wo)), 0};
    }
    [[nodiscard]] Scatter sample(RandomStream& stream) const {
      const double cosine = rayleigh_cosine_signed(2 * stream.uniform() - 1);
      return {deflect(-wi, cosine, stream.uniform()), 0};
    }
  };

  [[nodiscard]] double sigma(Direction) const { return 1; }
  [[nodiscard]] PhaseValue phase(Direction wi, Direction wo) const {
    return {rayleigh_phase(-dot(wi, wo)), 0};
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
  [[nodiscard]] double largest_density() const { return rayleigh_phase(1.0); }

  friend bool operator==(const Rayleigh&, const Rayleigh&) = default;
};

}  // namespace lamella
