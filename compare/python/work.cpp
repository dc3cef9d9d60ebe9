#include "compare/python/work.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include "compare/options/progress.h"

namespace lamella {

namespace py = pybind11;

namespace {

// What the working thread and the one that waits for it share.
struct Shared {
  std::mutex mutex;
  std::condition_variable changed;
  bool done = false;
  std::string line;  // of progress; empty: nothing new
  std::vector<std::string> warnings;
  std::exception_ptr failure;
};

RunMonitor monitor_of(Shared& shared, const StopFlag& stop, bool shown) {
  RunMonitor monitor{.stop = &stop};
  monitor.warning = [&shared](const std::string& message) {
    const std::lock_guard lock(shared.mutex);
    shared.warnings.push_back(message);
  };
  if (!shown) return monitor;
  const auto tell = [&shared](std::string line) {
    const std::lock_guard lock(shared.mutex);
    shared.line = std::move(line);
  };
  monitor.progress = [tell](const std::string& label, const Progress& p) {
    tell(progress_text(label, p, {}));
  };
  monitor.solver = [tell](const SolverProgress& p) { tell(progress_text(p)); };
  return monitor;
}

void run_in_arena(int threads, const std::function<void()>& work) {
  const int count = threads > 0 ? threads : tbb::this_task_arena::max_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(count));
  tbb::task_arena arena(count);
  arena.execute(work);
}

[[noreturn]] void raise_interrupt() {
  PyErr_SetNone(PyExc_KeyboardInterrupt);
  throw py::error_already_set();
}

}  // namespace

WorkEnd do_work(int threads, const py::object& show,
                const std::function<void(const RunMonitor&)>& work) {
  Shared shared;
  StopFlag stop = false;
  int interrupts = 0;
  std::optional<py::error_already_set> raised;  // by a handler or by `show`
  std::thread worker([&] {
    try {
      const RunMonitor monitor = monitor_of(shared, stop, !show.is_none());
      run_in_arena(threads, [&] { work(monitor); });
    } catch (...) {
      shared.failure = std::current_exception();
    }
    const std::lock_guard lock(shared.mutex);
    shared.done = true;
    shared.changed.notify_all();
  });
  const auto attend = [&](const std::string& line) {
    const py::gil_scoped_acquire acquire;
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (!line.empty()) show(line);
    } catch (py::error_already_set& error) {
      stop = true;
      if (error.matches(PyExc_KeyboardInterrupt))
        ++interrupts;
      else
        raised.emplace(error);
    }
  };
  {
    const py::gil_scoped_release release;
    std::unique_lock lock(shared.mutex);
    auto pause = std::chrono::milliseconds(5);
    while (!shared.changed.wait_for(lock, pause, [&] { return shared.done; })) {
      pause = std::min(2 * pause, std::chrono::milliseconds(100));
      std::string line;
      line.swap(shared.line);
      lock.unlock();
      attend(line);
      lock.lock();
    }
    lock.unlock();
    worker.join();
  }
  if (!show.is_none()) show(py::none());
  if (raised) throw py::error_already_set(*raised);
  if (shared.failure) std::rethrow_exception(shared.failure);
  if (interrupts > 1) raise_interrupt();
  return {interrupts > 0, std::move(shared.warnings)};
}

void do_whole_work(const std::function<void(const RunMonitor&)>& work) {
  if (do_work(0, py::none(), work).interrupted) raise_interrupt();
}

}  // namespace lamella
