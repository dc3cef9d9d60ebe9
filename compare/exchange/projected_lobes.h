#pragma once

#include <vector>

#include "analytic/model/model.h"
#include "compare/report/lobe_set.h"

namespace lamella {

/// A closed form on cells, like lobes of a truth: per order that it has a lobe of, and "all"; what
/// the projection left open stands for the standard error. Energies are the sums over cells.
/// Attributes tell directions, grid and conventions, not the model. Runs in the calling thread's
/// task arena.
[[nodiscard]] LobeSet projected_lobes(const Model& model, const ModelInfo& info,
                                      const std::vector<Direction>& directions,
                                      const CellGrid& grid, int channels);

}  // namespace lamella
