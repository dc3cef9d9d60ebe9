#pragma once

#include <string>
#include <vector>

#include "compare/options/options.h"
#include "compare/request/run_monitor.h"

namespace lamella {

/// A command with everything that its answer depends on: it can be done in parts, in other
/// processes, and its parts be put together by another.
struct DividedRun {
  std::string command;
  Options options;
  Stack stack{};
  std::vector<std::string> words{};     ///< of eval: truth and its key=value arguments, no stack
  std::string input{};                  ///< of eval: the pairs as CSV
  std::vector<std::string> pictures{};  ///< names of formats
  std::string folder{};                 ///< that answers of a sweep's points name files from
};

/// A command that can be divided.
struct DividedCommand {
  std::string name;
  std::string output;  ///< the type of its -o FILE or FOLDER; empty: it has none
  /// Throws UsageError where this run cannot be divided.
  void (*check)(const DividedRun&);
  /// Finds the pieces of a part for the monitor's keeper; no output.
  void (*find)(const DividedRun&, const RunMonitor&);
  /// The whole command. Returns the exit status.
  int (*finish)(const DividedRun&, const RunMonitor&);
};

[[nodiscard]] const DividedCommand& simulate_divided();
[[nodiscard]] const DividedCommand& compare_divided();
[[nodiscard]] const DividedCommand& furnace_divided();
[[nodiscard]] const DividedCommand& sweep_divided();
[[nodiscard]] const DividedCommand& eval_divided();

/// Does the run as its options say: as a whole, or the part that --shard names, with --checkpoint
/// or without. Returns the exit status.
int do_divided(const DividedCommand& command, const DividedRun& run);

/// Throws UsageError where walks that others count beside this part cannot be foreseen: a number
/// of walks must be given, and neither a time nor an error.
void check_walks_are_given(const TruthRequest& request);

/// The stack with its files named by their last names: the same for every place of the files.
[[nodiscard]] Stack with_bare_names(Stack stack);

/// Finds the truth of every direction.
void find_truths(const DividedRun& run, const RunMonitor& monitor);

}  // namespace lamella
