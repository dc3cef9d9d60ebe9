#include "volume/walk/incident_law.h"

#include <algorithm>
#include <cmath>

#include "phase/random/random.h"

namespace lamella {

Direction drawn_incident(IncidentLaw law, std::uint64_t seed, std::uint64_t walk, double least) {
  RandomStream stream(seed, walk, StreamPurpose::targets);
  const double u = stream.uniform(), phi = 2 * kPi * stream.uniform();
  const double mu = std::max(least, law == IncidentLaw::uniform ? u : std::sqrt(u));
  const double s = std::sqrt((1 - mu) * (1 + mu));
  return {s * std::cos(phi), s * std::sin(phi), mu};
}

}  // namespace lamella
