#pragma once

#include <vector>

#include "compare/request/model_request.h"

namespace lamella {

/// A closed form over a whole map: its mean over stacks of texels, one per stack in the order of
/// SurfaceStack::texels, all of one ModelInfo. Where parameters differ, those of the result are
/// their means, for echo, and their source says so. Its noise is the scatter between the texels of
/// each batch of the truth (StochasticModel::split), so that a comparison with a truth of the same
/// each batch of the truth (StochasticModel::split), so that a comparison with a truth of the same
/// texels sees the difference alone. Beside a truth that was solved on these texels it has no
/// noise: that is what `solved` asks for. The texels' models must not be empty.
[[nodiscard]] BoundModel mean_over_texels(std::vector<BoundModel> texels, bool solved = false);

}  // namespace lamella
