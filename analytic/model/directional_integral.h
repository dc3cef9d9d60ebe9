#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "phase/math/color.h"
#include "phase/math/direction.h"

namespace lamella {

/// The reason why an adaptive integral ended.
enum class IntegralEnd {
  tolerance,  ///< the error that was asked for is reached
  noise,      ///< the values' own noise, such as rounding in single precision, hides the rest
  limit,      ///< a limit on evaluations, or on how narrow a panel may be
  time        ///< the limit on time
};

/// "tolerance", "noise", "limit", "time"
[[nodiscard]] const char* to_text(IntegralEnd end);

/// The end as a reason in words, for people.
[[nodiscard]] const char* reason_of(IntegralEnd end);

/// An integral over directions, per channel.
struct DirectionalIntegral {
  Rgb value;
  /// Bound of the error: the differences between the rules of two orders, summed over the panels,
  /// and four standard deviations of the values' measured noise, as if all values had the same
  /// error (rounding of a constant or a parameter does change all values in the same way).
  Rgb error;
  std::uint64_t evaluations = 0;
  IntegralEnd end = IntegralEnd::tolerance;
};

/// When an adaptive integral ends.
struct IntegralLimits {
  double tolerance = 1e-9;              ///< of the integral of |g|, per channel
  std::uint64_t evaluations = 2000000;  ///< of one direction each
  double seconds = 10;                  ///< of the calling thread's wall clock
};

/// values[k] = g(directions[k]); the spans have the same length.
using DirectionalFunction =
    std::function<void(std::span<const Direction> directions, std::span<Rgb> values)>;

/// Integral of g(w) |mu| dw over the hemispheres whose signs of mu are `sides` (1, -1 or both), by
/// global adaptive cubature in mu and phi: Gauss-Kronrod's rule of 15 points along both, the panel
/// with the largest error halved next. `wi`: panels begin at its cosine and at multiples of 90
/// degrees from its azimuth, where models have their peaks and kinks.
///
/// It ends for every g: each panel's noise is measured by sixth differences of neighbours (More and
/// Wild 2011, "Estimating computational noise", eq. 2.2), and a panel is not halved if this noise
/// explains the difference of its rules. A jump, or a feature that is narrower than the panels can
/// be, ends at the limits. Throws std::domain_error, which names the direction, at a value that is
/// not finite.
[[nodiscard]] DirectionalIntegral integrate_projected(const DirectionalFunction& g, Direction wi,
                                                      std::span<const double> sides,
                                                      const IntegralLimits& limits = {});

}  // namespace lamella
