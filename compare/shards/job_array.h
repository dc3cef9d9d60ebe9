#pragma once

#include <functional>
#include <optional>
#include <string>

#include "compare/shards/shard.h"

namespace lamella {

/// The value of an environment variable, nothing where it is not set.
using EnvironmentVariables = std::function<std::optional<std::string>(const std::string& name)>;

/// The environment of this process.
[[nodiscard]] EnvironmentVariables process_environment();

/// --shard as typed: I/N; auto, the task of a scheduler's job array; or auto/N, the same where the
/// scheduler does not tell how many tasks there are, or runs some of them again.
///
/// | scheduler | task | tasks | auto/N |
/// | Slurm | SLURM_ARRAY_TASK_ID | from _MIN to _MAX in steps of _STEP, _COUNT of them | 1 to N |
/// | PBS | PBS_ARRAY_INDEX (Torque: PBS_ARRAYID) | not told | 1 to N |
/// | Grid Engine | SGE_TASK_ID | from _FIRST to _LAST in steps of _STEPSIZE | 1 to N |
/// | Kubernetes | JOB_COMPLETION_INDEX | not told | 0 to N - 1 |
///
/// Throws UsageError, which names the variables, where there is no task, where two schedulers have
/// one, and where variables contradict one another or N.
[[nodiscard]] Shard shard_from(const std::string& text, const EnvironmentVariables& environment);

}  // namespace lamella
