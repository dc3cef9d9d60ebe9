#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "compare/judge/comparison.h"

namespace lamella {

/// The verdict for people: "agrees", "insufficient", or "differs by 41 %", the relative RMSE
/// without noise (alone where that is 0 or infinite); where walks were cut, "differs by 12 to 41
/// %", wherever the missing light belongs.
[[nodiscard]] std::string verdict_text(const LobeComparison& lobe);

/// The meaning of a report's verdicts, for the foot of its table; lines end with '\n'. `max_order`:
/// of the walks.
[[nodiscard]] std::string verdict_legend(const std::vector<const LobeComparison*>& lobes,
                                         std::uint64_t max_order);

}  // namespace lamella
