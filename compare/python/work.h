#pragma once

#include <pybind11/pybind11.h>

#include <functional>
#include <string>
#include <vector>

#include "compare/request/run_monitor.h"

namespace lamella {

/// How long work came to its end, beside its answer.
struct WorkEnd {
  bool interrupted = false;           ///< by Ctrl-C: the answer is what was there
  std::vector<std::string> warnings;  ///< in the words of the command line
};

/// Does long work in a thread of its own, on `threads` threads (0: all), the interpreter's lock
/// released. Meanwhile the calling thread lets Python handle its signals: the first Ctrl-C sets the
/// monitor's flag, so that the work ends at its next checkpoint with what it has; after a second
/// one KeyboardInterrupt is raised once it has ended. Where the thread is not Python's main thread
/// signals are not its own. `show`: None, or a function that is told one line of progress now and
/// then, and None at the end. Throws what the work throws.
[[nodiscard]] WorkEnd do_work(int threads, const pybind11::object& show,
                              const std::function<void(const RunMonitor&)>& work);

/// The same for work whose half is no answer: Ctrl-C raises KeyboardInterrupt.
void do_whole_work(const std::function<void(const RunMonitor&)>& work);

}  // namespace lamella
