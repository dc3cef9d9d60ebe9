#pragma once

#include <cstdio>
#include <nlohmann/json.hpp>

#include "compare/options/options.h"
#include "compare/request/run_monitor.h"

namespace lamella {

/// `accuracy --spongecake`: prints the tables, and returns a row per stack.
[[nodiscard]] nlohmann::ordered_json spongecake_accuracy(const Options& options,
                                                         const RunMonitor& monitor,
                                                         std::FILE* out);

}  // namespace lamella
