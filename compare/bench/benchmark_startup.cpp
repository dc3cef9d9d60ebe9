#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compare/bench/benchmark.h"
#include "compare/request/interrupt.h"

extern char** environ;

namespace lamella {
namespace {

struct ProcessTime {
  double wall = 0, processor = 0;
  std::int64_t peak_bytes = 0;
};

double seconds_from(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

// One run of this program from its start to its end, without what it prints. Nothing where it did
// not start or not end with status 0.
std::optional<ProcessTime> time_of_run(const std::vector<std::string>& arguments) {
  std::vector<std::string> words{"lamella"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  for (const int file : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&actions, file, "/dev/null", O_RDWR, 0);
  pid_t child = 0;
  int status = 0;
  rusage used{};
  bool ended = false;
  const double wall = wall_seconds_of([&] {
    ended = posix_spawn(&child, "/proc/self/exe", &actions, nullptr, argv.data(), environ) == 0 &&
            wait4(child, &status, 0, &used) == child && WIFEXITED(status) &&
            WEXITSTATUS(status) == 0;
  });
  posix_spawn_file_actions_destroy(&actions);
  if (!ended) return std::nullopt;
  return ProcessTime{wall, seconds_from(used.ru_utime) + seconds_from(used.ru_stime),
                     std::int64_t{1024} * used.ru_maxrss};
}

double median_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

}  // namespace

void measure_startup(const BenchmarkEffort& effort, std::uint64_t, const ReportRow& report) {
  const std::vector<std::vector<std::string>> commands{
      {"--version"},
      {"stacks"},
      {"simulate", "lambert_sphere_halfspace", "--wi", "60", "--walks", "1e5"},
      {"simulate", "sggx_slab", "--wi", "60", "--walks", "1e5", "--estimator", "next-event"},
      {"simulate", "lambert_sphere_halfspace", "--wi", "60", "--tolerance", "1e-8", "--grid",
       "32x32"}};
  const int runs = effort.repetition_seconds < 0.05 ? 3 : 20;
  for (const std::vector<std::string>& command : commands) {
    std::string what = "startup/lamella";
    for (const std::string& word : command) what += " " + word;
    std::vector<double> wall, processor;
    std::int64_t peak = 0;
    for (int k = 0; k < runs && !user_interrupt; ++k)
      if (const auto time = time_of_run(command)) {
        wall.push_back(time->wall);
        processor.push_back(time->processor);
        peak = std::max(peak, time->peak_bytes);
      }
    if (wall.empty()) continue;
    BenchmarkRow row{.what = what, .kind = "startup"};
    row.seconds = median_of(wall);
    row.extra = {{"processor_seconds", median_of(processor)},
                 {"least_seconds", *std::min_element(wall.begin(), wall.end())},
                 {"peak_bytes", peak},
                 {"runs", wall.size()}};
    report(std::move(row));
  }
}

}  // namespace lamella
