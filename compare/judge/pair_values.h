#pragma once

#include <span>
#include <vector>

#include "analytic/model/model.h"

namespace lamella {

/// Whether the model is asked for many pairs at a time wherever many are needed.
[[nodiscard]] bool is_batched(const Model& model);

/// f of each pair: by one call of a BatchedModel, by a call per pair of any other.
[[nodiscard]] std::vector<Rgb> pair_values(const Model& model,
                                           std::span<const DirectionPair> pairs);

}  // namespace lamella
