#pragma once

#include <functional>
#include <string>

#include "compare/request/interrupt.h"
#include "volume/run/simulation.h"
#include "volume/solver/deterministic.h"

namespace lamella {

class RunKeeper;

/// Who watches while a truth is found, and may end it early. Each member may be absent; all are
/// called in the thread that asked for the truth.
struct RunMonitor {
  const StopFlag* stop = nullptr;
  /// How far walks have got, at every checkpoint. `label`: of the run, "theta_i 30".
  std::function<void(const std::string& label, const Progress&)> progress{};
  /// The solver's progress, every now and then.
  SolverReport solver{};
  /// Called at the end of a run and, if `solver` is set, at the end of the solver's work.
  std::function<void()> finished{};
  /// One line where a run reached less than was asked for, or where a setting has no effect.
  std::function<void(const std::string& message)> warning{};
  /// Where the run's walks are kept or divided (run_keeper.h).
  RunKeeper* keeper = nullptr;

  [[nodiscard]] bool is_stopped() const { return is_set(stop); }
  void warn(const std::string& message) const {
    if (warning) warning(message);
  }
};

}  // namespace lamella
