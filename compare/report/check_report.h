#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "compare/judge/model_check.h"

namespace lamella {

/// One check: its verdict, its name in `width` columns, its cases and the worst of them.
[[nodiscard]] std::string to_text(const CheckLine& line, int width);
/// The same as an object.
[[nodiscard]] nlohmann::ordered_json to_json(const CheckLine& line);

/// What a battery of checks found: a line per check with its verdict, its cases and the worst of
/// them; at most kTerminalWidth columns.
[[nodiscard]] std::string to_text(const ModelCheck& check);

/// The same as members of the JSON answer of `check`.
[[nodiscard]] nlohmann::ordered_json to_json(const ModelCheck& check);

}  // namespace lamella
