#pragma once

// Flights that are known to end within a way, on lanes: the chance that one does, and its length.
// Only for sources of lamella_lanes().

#include "phase/lanes/lane_math.h"
#include "phase/random/lane_random.h"

namespace lamella::LAMELLA_ISA {

/// 1 - exp(-tau), relative error below 6e-7, for 0 <= tau <= 80.
LAMELLA_INLINE Floats collision_chance(Floats tau) {
  constexpr float kSmall = 0.35f;  // where its series is
  Floats series = multiply_add(-tau, Floats(1.0f / 5040), Floats(1.0f / 720));
  for (const float term : {1.0f / 120, 1.0f / 24, 1.0f / 6, 0.5f, 1.0f})
    series = multiply_add(-tau, series, Floats(term));
  return select(tau < Floats(kSmall), tau * series, Floats(1) - exp(-tau));
}

/// An exponential number of mean 1 among those that have this chance in all: below -log(1 -
/// chance). Relative error below 3e-6.
LAMELLA_INLINE Floats truncated_exponential_of(Floats chance, Words word) {
  constexpr float kSmall = 0.05f;
  const Floats u = fine_uniform_of(word), x = chance * (Floats(1) - u);
  // -log(1 - x) by its series
  Floats series = multiply_add(x, Floats(0.2f), Floats(0.25f));
  series = multiply_add(x, series, Floats(1.0f / 3));
  series = multiply_add(x, series, Floats(0.5f));
  series = multiply_add(x * x, series, x);
  const Floats left = multiply_add(chance, u, Floats(1) - chance);
  return select(x < Floats(kSmall), series, -log(max(left, Floats(1e-30f))));
}

}  // namespace lamella::LAMELLA_ISA
