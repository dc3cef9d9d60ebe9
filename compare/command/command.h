#pragma once

#include "compare/options/options.h"

namespace lamella {

/// One function per command of the program; each prints its answer and returns the exit status.
/// Throws UsageError, StackFileError, OutputError or NonFiniteError, which main turns into
/// messages.
int simulate_command(const Options& options);
int compare_command(const Options& options);
int furnace_command(const Options& options);
/// Depth profiles in the place of the stack's grids, and what that costs.
int homogenise_command(const Options& options);
int bench_command(const Options& options);
/// What bench measures, in its order: the words of --only.
[[nodiscard]] std::vector<std::string> bench_parts();
int accuracy_command(const Options& options);
int preview_command(const Options& options);
int sweep_command(const Options& options);
int show_command(const Options& options);
int rerun_command(const Options& options);
int explain_command(const Options& options);
int models_command(const Options& options);
int media_command(const Options& options);
int stacks_command(const Options& options);
int measure_command(const Options& options);
/// `name`: of a published figure; empty: lists them.
int reproduce_command(const Options& options, const std::string& name);
/// `words`: the model and its key=value arguments.
int eval_command(const Options& options, const std::vector<std::string>& words);

/// `words`: the kind of grid to make and its key=value arguments; none: lists the kinds.
int grid_command(const Options& options, const std::vector<std::string>& words);

}  // namespace lamella
