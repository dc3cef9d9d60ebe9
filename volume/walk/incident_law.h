#pragma once

#include <cstdint>

#include "phase/math/direction.h"

namespace lamella {

/// How walks get their w_i: the same for all, or drawn by every walk over the upper hemisphere,
/// with equal density per solid angle (`uniform`, 1 / (2 pi)) or per projected solid angle
/// (`cosine`, mu / pi).
enum class IncidentLaw { fixed, uniform, cosine };

/// w_i of a walk that is followed in double, from the stream StreamPurpose::targets of (seed,
/// walk); mu >= least, which replaces smaller ones. `law` is not fixed.
[[nodiscard]] Direction drawn_incident(IncidentLaw law, std::uint64_t seed, std::uint64_t walk,
                                       double least);

}  // namespace lamella
