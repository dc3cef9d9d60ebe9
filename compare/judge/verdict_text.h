#pragma once

#include <string>

#include "compare/judge/comparison.h"

namespace lamella {

/// The verdict for people: "agrees", "insufficient", or "differs by 41 %", the relative RMSE
/// without noise (alone where that is 0 or infinite).
[[nodiscard]] std::string verdict_text(const LobeComparison& lobe);

}  // namespace lamella
