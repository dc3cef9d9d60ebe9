#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "compare/judge/model_check.h"

namespace lamella {

/// What a battery of checks found: a line per check with its verdict, its cases and the worst of
/// them; at most kTerminalWidth columns.
[[nodiscard]] std::string to_text(const ModelCheck& check);

/// The same as members of the JSON answer of `check`.
[[nodiscard]] nlohmann::ordered_json to_json(const ModelCheck& check);

}  // namespace lamella
