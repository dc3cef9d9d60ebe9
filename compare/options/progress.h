#pragma once

#include <cstdio>
#include <optional>
#include <string>

#include "compare/options/options.h"
#include "compare/request/run_monitor.h"

namespace lamella {

/// Where tables go: stdout, or stderr if the JSON takes stdout.
[[nodiscard]] std::FILE* table_stream(const Options& options);

/// The user at a terminal: Ctrl-C ends what runs (from this call on), progress stands in one line
/// of stderr if that is a terminal and --quiet is not given, warnings are lines of stderr.
[[nodiscard]] RunMonitor terminal_monitor(const Options& options);

/// How far walks have got, in one line. `label`: of the run; `seconds`: that they may take.
[[nodiscard]] std::string progress_text(const std::string& label, const Progress& p,
                                        std::optional<double> seconds);
/// What the solver is doing: "solver: 32 nodes, 24 modes so far, coarser ones reach 3.1e-04, 2 s".
[[nodiscard]] std::string progress_text(const SolverProgress& p);

}  // namespace lamella
