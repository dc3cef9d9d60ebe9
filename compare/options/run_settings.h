#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "compare/options/options.h"

namespace lamella {

/// The options that a run's numbers, files and status depend on, each with its value: neither the
/// stack nor anything about threads, terminals or places of files.
[[nodiscard]] nlohmann::ordered_json settings_json(const Options& options);

/// Options with those values. The JSON is untrusted: throws UsageError, which begins with `where`,
/// for a setting that is missing, unknown, of another type or out of its range.
[[nodiscard]] Options options_from(const nlohmann::ordered_json& settings,
                                   const std::string& where);

}  // namespace lamella
