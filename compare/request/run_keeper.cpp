#include "compare/request/run_keeper.h"

#include <algorithm>

namespace lamella {

double run_kept(Simulation& simulation, const StopRule& rule,
                const std::function<void(const Progress&)>& progress, const RunMonitor& monitor) {
  RunKeeper* const keeper = monitor.keeper;
  if (!keeper) return run(simulation, rule, progress, monitor.stop);
  const RunKeeper::Found found = keeper->begin(simulation);
  if (found.done) return found.seconds;
  StopRule left = rule;
  // A moment is left to walks that had their time.
  if (left.seconds) left.seconds = std::max(*left.seconds - found.seconds, 1e-3);
  const auto step = [&](Progress p) {
    p.seconds += found.seconds;
    if (progress) progress(p);
    if (simulation.walks() < rule.walks) keeper->checkpoint(simulation, p.seconds, false);
  };
  const double seconds = found.seconds + run(simulation, left, step, monitor.stop);
  if (monitor.is_stopped() && simulation.walks() < rule.walks)
    keeper->checkpoint(simulation, seconds, true);
  else
    keeper->end(simulation, seconds);
  return seconds;
}

}  // namespace lamella
