#pragma once

#include <optional>
#include <stdexcept>
#include <string>

#include "volume/result/run_result.h"

namespace lamella {

/// The solver was asked for and has no answer: what() is one line; exit status 3.
struct NoAnswerError : std::domain_error {
  using std::domain_error::domain_error;
};

/// Why a solution is no answer, if it is none: none of its steps had finite numbers, or the last
/// one changed f by more than f itself.
[[nodiscard]] std::optional<std::string> why_no_answer(const DeterministicAccuracy& accuracy);

/// The same of what the solver gives for one incident direction: numbers that are not finite, an
/// energy outside of [0, 1] or a ledger whose sum is not 1 by more than the bounds, or a bound
/// of an energy above a tenth of the light or, but for dark stacks, above the energy itself. Where
/// the clock or an interrupt ended refinement, and of a run that is repeated (`repeats`), which
/// ends where the first one did, bounds up to 2 are taken: what is there is kept. Rounding of 1e-12
/// is allowed.
[[nodiscard]] std::optional<std::string> why_no_answer(const RunResult& run, bool repeats = false);

}  // namespace lamella
