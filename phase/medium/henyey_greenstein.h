#pragma once

#include <cmath>

#include "phase/medium/henyey_greenstein_formulas.h"
#include "phase/medium/phase_function.h"

namespace lamella {

/// Particles with the Henyey-Greenstein phase function, g in (-1, 1). sigma = 1.
///
/// The rounding of the cosine changes a peak of width 1 - |g| by a relative error of up to 2e-15 /
/// (1 - |g|)^2. Peaks narrower than kNarrowPeak use the sum of the directions instead of the
/// cosine, |w_o + w_i|^2 / 2 = 1 - cosine; the remaining error is the rounding of the directions'
/// lengths, up to 1.4e-15 / (1 - |g|). A test holds both bounds against 60 digits.
struct HenyeyGreenstein {
  static constexpr double kNarrowPeak = 1e-3;  ///< 1 - |g|
  double g = 0;

  [[nodiscard]] static bool is_narrow(double g) { return 1 - std::abs(g) < kNarrowPeak; }
  /// p(w_i -> w_o) [1/sr].
  [[nodiscard]] static double phase_between(double g, Direction wi, Direction wo) {
    if (!is_narrow(g)) return henyey_greenstein_phase(g, -dot(wi, wo));
    const Direction chord = g < 0 ? wo - wi : wo + wi;
    return henyey_greenstein_phase_beside(g, dot(chord, chord) / 2);
  }

  struct Event {
    double g;
    Direction wi;

    [[nodiscard]] PhaseValue density(Direction wo) const { return {phase_between(g, wi, wo), 0}; }
    [[nodiscard]] Scatter sample(RandomStream& stream) const {
      const double u = stream.uniform();
      if (!is_narrow(g)) return {deflect(-wi, henyey_greenstein_cosine(g, u), stream.uniform()), 0};
      const double away = henyey_greenstein_away(g, u);
      const SineCosine<double> polar{std::sqrt(away * (2 - away)), g < 0 ? away - 1 : 1 - away};
      return {deflect(-wi, polar, sine_cosine_of_turns(stream.uniform())), 0};
    }
  };

  [[nodiscard]] double sigma(Direction) const { return 1; }
  [[nodiscard]] PhaseValue phase(Direction wi, Direction wo) const {
    return {phase_between(g, wi, wo), 0};
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
