#pragma once

#include "compare/nearest/nearest_models.h"
#include "compare/nearest/parametric_stack.h"
#include "compare/nearest/target_truths.h"

namespace lamella {

/// Searches of a stack's numbers, and the points that they are the best of: a stack is dearer than
/// a closed form.
inline constexpr int kStackStarts = 2, kStackTried = 8;
/// Walks per direction where the solver does not apply and none were asked for.
inline constexpr std::uint64_t kFitWalks = 100000;

/// The numbers of a stack that bring its lobes nearest to a target, in the same form as fits of
/// closed forms. `how`: estimator, tolerance, walks, seed and limits of the stack's lobes.
///
/// Where the solver applies every step of the last search has the nodes and modes that reach the
/// tolerance at the beginning (32 and 48 at most; searches before it have 12 nodes), so that
/// differences between steps are the stack's; what they miss is found by solving the answer to the
/// tolerance, twice, and is corrected. Elsewhere, or where walks are asked for, every step has the
/// same random numbers, derivatives are over wider steps, and the noise of the walks counts beside
/// the target's. Throws UsageError where the stack has no values, or fewer channels than the target
/// has colour.
[[nodiscard]] NearestModels nearest_stack(const TargetTruths& target, const ParametricStack& stack,
                                          const TruthRequest& how, FitNorm norm, FitSides sides,
                                          const RunMonitor& monitor);

/// Judges the fitted stack on the truths of other directions than its own: HeldOut of `nearest`.
/// `stack`, `how`: of nearest_stack; walks have other random numbers than there, so that they share
/// none with the target's. Where there is no light along the directions, nothing.
void judge_stack_held_out(NearestModels& nearest, const TargetTruths& others,
                          const ParametricStack& stack, TruthRequest how,
                          const RunMonitor& monitor);

/// The fitted stack in the place of a model that is judged: its name and its numbers, in `info`,
/// which must outlive it, and no values of its own.
[[nodiscard]] BoundModel fitted_stack_model(const ModelFit& fit, ModelInfo& info);

/// The fitted stack against the target, per order where the target has orders. Its walks do not
/// count as the target's do: kErrorsAsBound of their standard errors, or the solver's bounds, are
/// not held against it. `model`: of fitted_stack_model.
[[nodiscard]] StackComparison compare_with_stack(const TargetTruths& target, const ModelFit& fit,
                                                 const BoundModel& model);

}  // namespace lamella
