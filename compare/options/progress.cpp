#include "compare/options/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "compare/request/interrupt.h"

namespace lamella {

std::FILE* table_stream(const Options& options) { return options.json == "-" ? stderr : stdout; }

RunMonitor terminal_monitor(const Options& options) {
  catch_interrupts();
  RunMonitor monitor{.stop = &user_interrupt};
  monitor.warning = [](const std::string& message) {
    fmt::print(stderr, "lamella: warning: {}\n", message);
  };
  if (options.quiet || !isatty(STDERR_FILENO)) return monitor;
  monitor.progress = [seconds = options.seconds](const std::string& label, const Progress& p) {
    const double rate = static_cast<double>(p.walks) / std::max(p.seconds, 1e-9);
    double left = static_cast<double>(p.of_walks - p.walks) / rate;
    if (seconds) left = std::min(left, std::max(0.0, *seconds - p.seconds));
    fmt::print(stderr, "\r{}: {:.3g} of {:.3g} walks, {:.3g}/s, {:.0f} s left \x1b[K", label,
               static_cast<double>(p.walks), static_cast<double>(p.of_walks), rate, left);
    std::fflush(stderr);
  };
  monitor.finished = [] { fmt::print(stderr, "\r\x1b[K"); };
  return monitor;
}

}  // namespace lamella
