#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "compare/options/options.h"
#include "compare/ranks/ranks.h"
#include "compare/report/input_files.h"
#include "compare/request/run_monitor.h"
#include "compare/shards/part_file.h"
#include "compare/shards/shard.h"

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
  std::vector<Stack> texels{};          ///< TruthRequest::texels
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
  /// The work of every rank and, on rank 0, the rest of the command, where ranks take turns that
  /// are not those of parts; else absent. Returns the exit status.
  int (*by_ranks)(const DividedRun&, const RunMonitor&, Ranks&) = nullptr;
};

[[nodiscard]] const DividedCommand& simulate_divided();
[[nodiscard]] const DividedCommand& compare_divided();
[[nodiscard]] const DividedCommand& furnace_divided();
[[nodiscard]] const DividedCommand& sweep_divided();
[[nodiscard]] const DividedCommand& eval_divided();
[[nodiscard]] const DividedCommand& samples_divided();

/// Does the run as its options say: as a whole, or the part that --shard names, with --checkpoint
/// or without. Returns the exit status.
int do_divided(const DividedCommand& command, const DividedRun& run);

/// The same by all processes that mpirun started, each of which calls it: ranks find the parts of
/// the run, rank 0 puts them together in memory and writes. Rank 0 compares first what the others
/// were asked for. With --checkpoint every rank has a file of its own, FILE.I-of-N. Returns the
/// exit status on rank 0, and 0 on the others once rank 0 is done.
int do_by_ranks(const DividedCommand& command, const DividedRun& run, Ranks& ranks);

/// Holds what all ranks were asked for against each other, and the programs that they are: where
/// they differ rank 0 throws UsageError, which names rank and difference, and the others wait.
void agree_by_ranks(const nlohmann::ordered_json& request, Ranks& ranks);
/// Throws UsageError.
void refuse_shard_of_ranks(const Options& options);
/// Of the terminal on rank 0, silent on the others; stopped where mpirun ends the ranks.
[[nodiscard]] RunMonitor monitor_of_rank(const Options& options, const Ranks& ranks);

/// What numbers depend on: equal for all parts of a run.
[[nodiscard]] nlohmann::ordered_json identity_of(const DividedRun& run, const InputFiles& inputs);

/// The work of one part.
struct PartWork {
  StoredPieces pieces{};
  bool idle = false;  ///< it had none: the solver's answer is the first part's
};
/// Finds a part; `checkpoint`: the file to go on from, empty for none, locked by the caller.
/// Where the monitor stops it, writes the checkpoint and throws UsageError.
[[nodiscard]] PartWork find_part(const DividedCommand& command, const DividedRun& run,
                                 const Shard& shard, const std::string& checkpoint,
                                 RunMonitor monitor, bool quiet);

/// Throws UsageError where walks that others count beside this part cannot be foreseen: a number
/// of walks must be given, and neither a time nor an error.
void check_walks_are_given(const TruthRequest& request);

/// The stack with its files named by their last names: the same for every place of the files.
[[nodiscard]] Stack with_bare_names(Stack stack);

/// The request for a run's truth, texels included.
[[nodiscard]] TruthRequest request_of(const DividedRun& run);

/// Finds the truth of every direction.
void find_truths(const DividedRun& run, const RunMonitor& monitor);

}  // namespace lamella
