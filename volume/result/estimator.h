#pragma once

#include <string>

namespace lamella {

/// analog: walks counted in the cells where they leave; next_event: every event's light sent to
/// every cell or point; deterministic: adding and doubling (volume/solver/deterministic.h), without
/// walks.
enum class Estimator { analog, next_event, deterministic };

[[nodiscard]] std::string to_text(Estimator estimator);

}  // namespace lamella
