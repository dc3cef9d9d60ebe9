#pragma once

#include <cstdio>

#include "compare/options/options.h"
#include "compare/request/run_monitor.h"

namespace lamella {

/// Where tables go: stdout, or stderr if the JSON takes stdout.
[[nodiscard]] std::FILE* table_stream(const Options& options);

/// The user at a terminal: Ctrl-C ends what runs (from this call on), progress stands in one line
/// of stderr if that is a terminal and --quiet is not given, warnings are lines of stderr.
[[nodiscard]] RunMonitor terminal_monitor(const Options& options);

}  // namespace lamella
