#pragma once

#include <functional>
#include <optional>
#include <string>

#include "compare/request/run_monitor.h"
#include "volume/run/simulation.h"

namespace lamella {

/// Keeps what a run finds, piece by piece, in the order in which the run asks for the pieces: a
/// simulation's walks, or anything else as bytes. So a run can be divided among processes, put
/// together again, and go on where it was ended (compare/shards). The run must ask for the same
/// pieces in the same order whenever it is repeated.
class RunKeeper {
 public:
  /// What is known of a simulation's walks.
  struct Found {
    bool done = false;   ///< no walk is left to do
    double seconds = 0;  ///< that the walks so far took
  };
  using Make = std::function<std::string()>;

  virtual ~RunKeeper() = default;

  /// The next piece is the walks of a simulation: restores those that are kept, and leaves to it
  /// the batches that are this process's.
  [[nodiscard]] virtual Found begin(Simulation& simulation) = 0;
  /// Between the steps of these walks. `now`: the run ends here, before they are done.
  virtual void checkpoint(const Simulation& simulation, double seconds, bool now) = 0;
  /// The walks are done.
  virtual void end(const Simulation& simulation, double seconds) = 0;
  /// The next piece is these bytes: those that are kept, or what `make` returns, or nothing where
  /// another process finds them.
  [[nodiscard]] virtual std::optional<std::string> piece(const Make& make) = 0;
};

/// `run` under the eyes of the monitor's keeper, if it has one. Returns the seconds that the walks
/// took, those before a restart among them.
double run_kept(Simulation& simulation, const StopRule& rule,
                const std::function<void(const Progress&)>& progress, const RunMonitor& monitor);

}  // namespace lamella
