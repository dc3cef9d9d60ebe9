#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compare/request/interrupt.h"
#include "compare/request/truth_request.h"
#include "volume/result/run_result.h"
#include "volume/solver/deterministic.h"

namespace lamella {

/// Which estimator finds the truth of a stack, and why.
struct EstimatorChoice {
  Estimator estimator = Estimator::analog;
  std::string reason;
  /// The solved stack, where the estimator is deterministic and the stack symmetric about the
  /// normal; else cells are solved in spherical harmonics (volume/harmonics).
  std::shared_ptr<const DeterministicSolution> solution;

  /// Whether the deterministic estimator works in spherical harmonics.
  [[nodiscard]] bool has_harmonics() const {
    return estimator == Estimator::deterministic && !solution;
  }
};

/// What a truth is asked for: cells, which both solvers have, or f at pairs of directions, which
/// only that of symmetric stacks has.
enum class TruthAt { cells, pairs };

/// The estimator asked for, or what `auto` stands for: a walk where an option was given that only
/// walks have a use for, or where the solver does not apply; else the deterministic solver, with
/// few enough nodes and modes (which are the same on any machine) to be done in seconds, if it
/// reaches the tolerance, or less than the walks would leave of an energy at best, or is
/// interrupted on the way with what it has; else a walk. `of_walks`: the estimator of walks where
/// none is named. `report` is told what the solver does. Throws UsageError where the solver is
/// asked for and does not apply, NoAnswerError where it is asked for and has no answer.
[[nodiscard]] EstimatorChoice choose_estimator(const TruthRequest& request, Estimator of_walks,
                                               const StopFlag* stop,
                                               const SolverReport& report = {},
                                               TruthAt at = TruthAt::cells);

/// Why walks answer better than these cells of a solution, if they do: the solution has no answer
/// for a direction (volume/solver/answer_check.h), or its cells have larger bounds than walks would
/// leave errors, and miss the tolerance.
[[nodiscard]] std::optional<std::string> why_walks_are_better(const std::vector<RunResult>& solved,
                                                              const TruthRequest& request);

/// Throws NoAnswerError with one line: that reason, and what else is allowed.
[[noreturn]] void refuse_answer(const Stack& stack, const std::string& reason);

/// A finer solution than the choice's, where cells miss a tolerance that the solver's probes met:
/// pairs of directions and the quadratures over cells have errors of their own.
[[nodiscard]] std::shared_ptr<const DeterministicSolution> refined(const TruthRequest& request,
                                                                   const StopFlag* stop,
                                                                   const SolverReport& report = {});

/// Why `auto` took the solver: "the solver reaches 6.9e-08 with 24 nodes and 60 modes".
[[nodiscard]] std::string reached_by(const DeterministicSolution& solution);

/// For a table: "deterministic estimator (auto: ...), tolerance 1e-6" or "analog estimator, seed
/// 1".
[[nodiscard]] std::string estimator_text(const EstimatorChoice& choice,
                                         const TruthRequest& request);

/// Throws UsageError where the deterministic estimator is asked for and does not apply: cheap,
/// before any work.
void check_estimator(const TruthRequest& request, TruthAt at = TruthAt::cells);

/// Cells of a stack without symmetry about the normal. Of a run that is repeated: at the degree
/// that it ended with.
[[nodiscard]] std::vector<RunResult> harmonic_cells(const TruthRequest& request, const Plan& plan,
                                                    const StopFlag* stop,
                                                    const SolverReport& report);

/// Why `auto` took them: "the solver reaches 6.9e-05 with spherical harmonics of degree 34".
[[nodiscard]] std::string reached_by(const std::vector<RunResult>& harmonic_cells);

}  // namespace lamella
