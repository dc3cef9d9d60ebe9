#pragma once

#include "phase/medium/henyey_greenstein_formulas.h"
#include "phase/medium/phase_function.h"

namespace lamella {

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
  [[nodiscard]] MediumTraits traits() const {
    return {.two_sided = true,
            .symmetric_about_z = true,
            .has_axis = false,
            .mean_normal = Direction{0, 0, 0},
            .shape = PhaseShape::smooth,
            .mean_cosine = g};
  }
  [[nodiscard]] double largest_density() const { return henyey_greenstein_phase(std::abs(g), 1.0); }

  friend bool operator==(const HenyeyGreenstein&, const HenyeyGreenstein&) = default;
};

}  // namespace lamella
