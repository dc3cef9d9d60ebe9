#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "volume/result/run_result.h"

namespace lamella {

/// How far the mean over solved texels may be from the mean of their map, beside the solver's
/// bounds (Truth::map_error): a line per quantity that has light, indented.
[[nodiscard]] std::string map_error_text(const RunResult& map_error, int indent);

/// The same: standard errors per channel of "reflected", "transmitted", "uncollided" and
/// "absorbed".
[[nodiscard]] nlohmann::ordered_json map_error_json(const RunResult& map_error);

}  // namespace lamella
