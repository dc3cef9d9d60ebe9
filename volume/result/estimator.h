#pragma once

#include <string>

namespace lamella {

/// analog: photons counted in cells; next_event: every collision seen from every cell or point;
/// deterministic: adding and doubling (volume/solver/deterministic.h), without walks.
enum class Estimator { analog, next_event, deterministic };

[[nodiscard]] std::string to_text(Estimator estimator);

}  // namespace lamella
