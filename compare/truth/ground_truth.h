#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compare/request/first_look.h"
#include "compare/request/run_monitor.h"
#include "compare/request/truth_request.h"
#include "compare/truth/estimator_choice.h"
#include "volume/result/run_result.h"
#include "volume/run/simulation.h"

namespace lamella {

/// The truth of one incident direction.
struct Truth {
  RunResult run;
  /// The batches that `run` was reduced from: their scatter is its noise. None where the solver
  /// found it: `run` then has error bounds.
  std::unique_ptr<Simulation> batches;
  /// Of a mean over the texels of a map that the solver found: the same values, with standard
  /// errors that the sample of texels leaves of the map's mean; `run` has the solver's bounds.
  std::optional<RunResult> map_error{};
};

/// The source of truth for the commands, whichever estimator finds it: one truth per incident
/// direction of a stack.
class GroundTruth {
 public:
  /// `of_walks`: the estimator of walks where the request leaves the choice. Throws UsageError
  /// where the estimator does not suit the stack.
  GroundTruth(TruthRequest request, Estimator of_walks, RunMonitor monitor = {});

  [[nodiscard]] const TruthRequest& request() const { return request_; }
  [[nodiscard]] const Plan& plan() const { return plan_; }
  [[nodiscard]] const std::vector<Direction>& directions() const { return request_.directions; }
  /// Whether the monitor's flag is set: the truth is then less complete than what was asked for.
  [[nodiscard]] bool is_stopped() const { return monitor_.is_stopped(); }
  [[nodiscard]] const StopFlag* stop() const { return monitor_.stop; }
  /// Of a mean over texels that were solved: the nodes and modes at which each ended, of those that
  /// were solved before a stop. Empty where walks answer, and before choice().
  [[nodiscard]] const std::vector<TruthRequest::SolverEnd>& texel_ends() const {
    return texel_ends_;
  }

  /// The estimator and why it was chosen; the first call may solve the stack.
  [[nodiscard]] const EstimatorChoice& choice();
  [[nodiscard]] Estimator estimator() { return choice().estimator; }

  /// Whether the k-th direction can still be found: the first always; all until the monitor stops;
  /// after that, those that a solution answers, whichever nodes and modes it ended with.
  [[nodiscard]] bool goes_on(std::size_t k) const;
  /// The truth of the k-th direction. A stop ends a walk at the next checkpoint; so does the clock
  /// where no effort was asked for (FirstLook). Warns where a run reached less than was asked for.
  /// `walks`: a number for this direction in the place of the request's; no clock ends these walks.
  [[nodiscard]] Truth find(std::size_t k, std::optional<std::uint64_t> walks = {});

 private:
  void choose();
  // The same where the truth is the mean over a map.
  void choose_for_texels();
  // The mean of the solved texels; false where one of them is better walked.
  [[nodiscard]] bool solve_texels(const std::vector<std::size_t>& first_equal);
  // The choice and what was solved with it, as a keeper has them.
  [[nodiscard]] std::string choice_bytes() const;
  void restore_choice(std::string_view bytes);
  // The cells of the choice's solution, or walks in its place where they are better.
  void solve_cells();
  // The same of a stack without symmetry about the normal.
  void solve_harmonics();
  void warn_of_walk_settings() const;

  TruthRequest request_;
  Estimator of_walks_;
  RunMonitor monitor_;
  Plan plan_;
  std::optional<EstimatorChoice> choice_;
  std::vector<RunResult> solved_;      // one per direction, once the solver was used
  std::vector<RunResult> map_errors_;  // beside them, of a mean over a map
  std::vector<TruthRequest::SolverEnd> texel_ends_;
  FirstLook look_;
};

/// Why a result keeps its walks' own order 1: its closed form has another mean. One is at fault.
[[nodiscard]] std::optional<std::string> why_order_one_is_wrong(const RunResult& run);

/// Runs walks until the rule says stop and reduces them. `label`: of the run, for the monitor,
/// which is warned where the walks ran out before the target error was reached, and where order 1
/// stays as walked (why_order_one_is_wrong).
[[nodiscard]] RunResult run_walks(Simulation& simulation, const StopRule& rule,
                                  const std::string& label, const RunMonitor& monitor);

}  // namespace lamella
