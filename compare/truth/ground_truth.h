#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "compare/judge/comparison.h"
#include "compare/options/options.h"
#include "compare/request/model_request.h"
#include "compare/truth/estimator_choice.h"
#include "volume/result/run_result.h"
#include "volume/run/simulation.h"

namespace lamella {

/// What was found for one incident direction.
struct Truth {
  RunResult run;
  /// The batches that `run` was reduced from: their scatter is its noise. None where the solver
  /// found it: `run` then has error bounds.
  std::unique_ptr<Simulation> batches;
};

/// Where the commands get their truth from, whichever estimator finds it: one per incident
/// direction of a stack.
class GroundTruth {
 public:
  /// `of_walks`: the estimator of walks where the options leave the choice. Throws UsageError where
  /// directions or estimator do not suit the stack.
  GroundTruth(const Stack& stack, const Options& options, CellGrid grid, Estimator of_walks);
  /// The same for directions that are no option's.
  GroundTruth(const Stack& stack, const Options& options, CellGrid grid, Estimator of_walks,
              std::vector<Direction> directions);

  [[nodiscard]] const Plan& plan() const { return plan_; }
  [[nodiscard]] const std::vector<Direction>& directions() const { return directions_; }

  /// The estimator and why it was chosen; the first call may solve the stack.
  [[nodiscard]] const EstimatorChoice& choice();
  [[nodiscard]] Estimator estimator() { return choice().estimator; }

  /// Whether the k-th direction is still to be had: the first always, all until Ctrl-C, and after
  /// it those that a solution answers, whichever nodes and modes it ended with.
  [[nodiscard]] bool goes_on(std::size_t k) const;
  /// The truth of the k-th direction, with progress on a terminal. Ctrl-C ends a walk at the next
  /// checkpoint and sets `interrupted`. Says on stderr where less was reached than was asked for.
  /// `walks`: of this direction, where they are no option's.
  [[nodiscard]] Truth find(std::size_t k, std::optional<std::uint64_t> walks = {});

 private:
  Stack stack_;
  Options options_;
  CellGrid grid_;
  Estimator of_walks_;
  Plan plan_;
  std::vector<Direction> directions_;
  std::optional<EstimatorChoice> choice_;
  std::vector<RunResult> solved_;  // one per direction, once the solver was used
};

/// A closed form against the truth of one direction: every lobe it stands for, on each side that
/// the plan has. Verdicts wait for `decide`.
[[nodiscard]] std::vector<LobeComparison> judge(const Truth& truth, const Plan& plan,
                                                const BoundModel& model);

}  // namespace lamella
