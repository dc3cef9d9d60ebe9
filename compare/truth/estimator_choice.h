#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "compare/request/interrupt.h"
#include "compare/request/truth_request.h"
#include "volume/harmonics/harmonic_pairs.h"
#include "volume/result/run_result.h"
#include "volume/solver/deterministic.h"

namespace lamella {

/// Which estimator finds the truth of a stack, and why.
struct EstimatorChoice {
  Estimator estimator = Estimator::analog;
  std::string reason;
  /// The solved stack, where the estimator is deterministic and the stack symmetric about the
  /// normal; else cells and pairs are solved in spherical harmonics (volume/harmonics).
  std::shared_ptr<const DeterministicSolution> solution;

  /// Whether the deterministic estimator works in spherical harmonics.
  [[nodiscard]] bool has_harmonics() const {
    return estimator == Estimator::deterministic && !solution;
  }
};

/// The estimator asked for, or the choice of `auto`. `auto` takes walks where an option was given
/// that has a use for walks only, or where the solver does not apply. Else it tries the
/// deterministic solver, with few enough nodes and modes (the same on any machine) to be done in
/// seconds, and takes the solution if it reaches the tolerance, if its error is smaller than the
/// error of an energy by walks at best, or if it is interrupted on the way. Else it takes walks.
/// A stack that is not symmetric about the normal is solved in spherical harmonics,
/// unless the stack scatters too narrowly. `of_walks`: the estimator of walks where none is named.
/// `report` receives the solver's progress. Throws UsageError where the solver is asked for and
/// does not apply, NoAnswerError where it is asked for and has no answer.
[[nodiscard]] EstimatorChoice choose_estimator(const TruthRequest& request, Estimator of_walks,
                                               const StopFlag* stop,
                                               const SolverReport& report = {});

/// The reason why walks answer better than these cells of a solution, if they do: the solution has
/// no answer for a direction (volume/solver/answer_check.h), or its cells miss the tolerance and
/// have bounds above the errors of walks.
[[nodiscard]] std::optional<std::string> why_walks_are_better(const std::vector<RunResult>& solved,
                                                              const TruthRequest& request);

/// Throws NoAnswerError with one line: that reason, and the alternatives.
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
void check_estimator(const TruthRequest& request);

/// Cells of a stack without symmetry about the normal. Of a run that is repeated: at the degree
/// that it ended with.
[[nodiscard]] std::vector<RunResult> harmonic_cells(const TruthRequest& request, const Plan& plan,
                                                    const StopFlag* stop,
                                                    const SolverReport& report);

/// f at pairs (w_i, w_o) in spherical harmonics, within the request's time.
[[nodiscard]] std::vector<HarmonicPair> harmonic_values(
    const TruthRequest& request, std::span<const std::pair<Direction, Direction>> pairs,
    const StopFlag* stop, const SolverReport& report, DeterministicAccuracy& accuracy);

/// Why `auto` took them: "the solver reaches 6.9e-05 with spherical harmonics of degree 34".
[[nodiscard]] std::string reached_by(const std::vector<RunResult>& harmonic_cells);

}  // namespace lamella
