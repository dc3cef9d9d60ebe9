#include "compare/shards/job_array.h"

#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <vector>

#include "compare/request/errors.h"
#include "compare/request/numbers.h"

namespace lamella {
namespace {

// The variables of a scheduler; empty: it has none of that kind.
struct Scheduler {
  const char* name;
  const char* task;
  const char* first;
  const char* last;
  const char* step;
  const char* count;
  std::uint64_t least;    // task of auto/N that is part 1
  const char* submitted;  // as the tasks of auto are asked for
};

constexpr std::array kSchedulers{
    Scheduler{"Slurm", "SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_MIN", "SLURM_ARRAY_TASK_MAX",
              "SLURM_ARRAY_TASK_STEP", "SLURM_ARRAY_TASK_COUNT", 1, "sbatch --array=1-N"},
    Scheduler{"PBS", "PBS_ARRAY_INDEX", "", "", "", "", 1, "qsub -J 1-N"},
    Scheduler{"Torque", "PBS_ARRAYID", "", "", "", "", 1, "qsub -t 1-N"},
    Scheduler{"Grid Engine", "SGE_TASK_ID", "SGE_TASK_FIRST", "SGE_TASK_LAST", "SGE_TASK_STEPSIZE",
              "", 1, "qsub -t 1-N"},
    Scheduler{"Kubernetes", "JOB_COMPLETION_INDEX", "", "", "", "", 0,
              "completionMode: Indexed, completions: N"},
};

std::optional<std::string> value_of(const EnvironmentVariables& environment, const char* name) {
  if (*name == '\0') return std::nullopt;
  std::optional<std::string> value = environment(name);
  // Grid Engine sets it to this in jobs that are no arrays.
  if (value && (value->empty() || *value == "undefined")) return std::nullopt;
  return value;
}

// Digits alone: a scheduler writes nothing else.
std::optional<std::uint64_t> number_in(const EnvironmentVariables& environment, const char* name) {
  const std::optional<std::string> text = value_of(environment, name);
  if (!text) return std::nullopt;
  if (text->size() <= 18 && text->find_first_not_of("0123456789") == std::string::npos)
    return parse_whole_number(*text);
  throw UsageError(
      fmt::format("--shard auto: found {} = \"{}\"; allowed: a whole number", name, *text));
}

const Scheduler& scheduler_of(const EnvironmentVariables& environment) {
  std::vector<const Scheduler*> found;
  std::string names;
  for (const Scheduler& s : kSchedulers) {
    names += fmt::format("{}{}", names.empty() ? "" : ", ", s.task);
    if (value_of(environment, s.task)) found.push_back(&s);
  }
  if (found.empty())
    throw UsageError(fmt::format(
        "--shard auto: found no task of a job array; allowed: one of {}, or --shard I/N", names));
  if (found.size() > 1)
    throw UsageError(
        fmt::format("--shard auto: found {} beside {}; allowed: one of them, or "
                    "--shard I/N",
                    found[0]->task, found[1]->task));
  return *found.front();
}

Shard of_given_count(const Scheduler& s, std::uint64_t task, std::uint64_t count) {
  if (task < s.least || task - s.least >= count)
    throw UsageError(fmt::format("--shard auto/{}: found {} = {}; allowed: from {} to {} ({})",
                                 count, s.task, task, s.least, s.least + count - 1, s.submitted));
  return {task - s.least + 1, count};
}

Shard of_told_count(const Scheduler& s, std::uint64_t task,
                    const EnvironmentVariables& environment) {
  const auto first = number_in(environment, s.first), last = number_in(environment, s.last);
  if (!first || !last)
    throw UsageError(fmt::format(
        "--shard auto: found {} = {}, but {} does not say how many tasks there are; allowed: "
        "--shard auto/N",
        s.task, task, s.name));
  const std::uint64_t step = number_in(environment, s.step).value_or(1);
  if (step == 0 || *last < *first || task < *first || task > *last || (task - *first) % step != 0)
    throw UsageError(fmt::format(
        "--shard auto: found {} = {} with tasks from {} to {} in steps of {}, of which it is none; "
        "allowed: variables of one job array, or --shard auto/N",
        s.task, task, *first, *last, step));
  const std::uint64_t count = (*last - *first) / step + 1;
  if (const auto told = number_in(environment, s.count); told && *told != count)
    throw UsageError(
        fmt::format("--shard auto: found {} = {} where tasks from {} to {} in steps of {} are {}; "
                    "allowed: {} without gaps, or --shard auto/N",
                    s.count, *told, *first, *last, step, count, s.submitted));
  if (count > kMostShards)
    throw UsageError(
        fmt::format("--shard auto: found {} tasks; allowed: up to {}", count, kMostShards));
  return {(task - *first) / step + 1, count};
}

}  // namespace

EnvironmentVariables process_environment() {
  return [](const std::string& name) -> std::optional<std::string> {
    const char* value = std::getenv(name.c_str());
    return value ? std::optional<std::string>(value) : std::nullopt;
  };
}

Shard shard_from(const std::string& text, const EnvironmentVariables& environment) {
  if (text != "auto" && !text.starts_with("auto/")) return parse_shard(text);
  // The count is held against its range before there is a task to look for.
  std::optional<std::uint64_t> count;
  if (text != "auto") count = parse_shard("1/" + text.substr(5)).count;
  const Scheduler& s = scheduler_of(environment);
  const std::uint64_t task = number_in(environment, s.task).value();
  return count ? of_given_count(s, task, *count) : of_told_count(s, task, environment);
}

}  // namespace lamella
