#include "compare/options/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <string>

#include "compare/request/interrupt.h"

namespace lamella {
namespace {

using SolverClock = std::chrono::steady_clock;

}  // namespace

std::string progress_text(const SolverProgress& p) {
  switch (p.task) {
    case SolverProgress::Task::cells:
      return fmt::format("solver: {} nodes reach {:.1e}; cells {:.0f} %, {:.0f} s", p.nodes,
                         p.error, 100 * p.share, p.seconds);
    case SolverProgress::Task::pairs:
      return fmt::format("solver: {} nodes reach {:.1e}; pairs {:.0f} %, {:.0f} s", p.nodes,
                         p.error, 100 * p.share, p.seconds);
    case SolverProgress::Task::nodes:
      break;
  }
  return fmt::format("solver: {} nodes, {} modes so far{}, {:.0f} s", p.nodes, p.modes,
                     p.error < 1 ? fmt::format(", coarser ones reach {:.1e}", p.error) : "",
                     p.seconds);
}

std::string progress_text(const std::string& label, const Progress& p,
                          std::optional<double> seconds) {
  const double rate = static_cast<double>(p.walks) / std::max(p.seconds, 1e-9);
  double left = static_cast<double>(p.of_walks - p.walks) / rate;
  if (seconds) left = std::min(left, std::max(0.0, *seconds - p.seconds));
  return fmt::format("{}: {:.3g} of {:.3g} walks, {:.3g}/s, {:.0f} s left", label,
                     static_cast<double>(p.walks), static_cast<double>(p.of_walks), rate, left);
}

std::FILE* table_stream(const Options& options) { return options.json == "-" ? stderr : stdout; }

RunMonitor terminal_monitor(const Options& options) {
  catch_interrupts();
  RunMonitor monitor{.stop = &user_interrupt};
  monitor.warning = [](const std::string& message) {
    fmt::print(stderr, "lamella: warning: {}\n", message);
  };
  if (options.quiet || !isatty(STDERR_FILENO)) return monitor;
  monitor.progress = [seconds = options.seconds](const std::string& label, const Progress& p) {
    fmt::print(stderr, "\r{} \x1b[K", progress_text(label, p, seconds));
    std::fflush(stderr);
  };
  monitor.solver = [next = SolverClock::now()](const SolverProgress& p) mutable {
    const SolverClock::time_point now = SolverClock::now();
    if (now < next) return;
    next = now + std::chrono::milliseconds(200);
    fmt::print(stderr, "\r{}\x1b[K", progress_text(p));
    std::fflush(stderr);
  };
  monitor.finished = [] { fmt::print(stderr, "\r\x1b[K"); };
  return monitor;
}

}  // namespace lamella
