#pragma once

#include <string>
#include <string_view>

#include "volume/result/run_result.h"

namespace lamella {

/// A result as bytes, each number with all of its bits.
[[nodiscard]] std::string to_bytes(const RunResult& run);

/// The result that to_bytes wrote. Throws DamagedBytes, before it makes room for more than there
/// is.
[[nodiscard]] RunResult run_from_bytes(std::string_view bytes);

}  // namespace lamella
