#pragma once

#include <vector>

#include "compare/judge/comparison.h"
#include "compare/request/model_request.h"
#include "compare/truth/ground_truth.h"

namespace lamella {

/// A closed form against the truth of one direction: every lobe it stands for, on each side that
/// the plan has. Verdicts wait for `decide`.
[[nodiscard]] std::vector<LobeComparison> judge(const Truth& truth, const Plan& plan,
                                                const BoundModel& model);

}  // namespace lamella
