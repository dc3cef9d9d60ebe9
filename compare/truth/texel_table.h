#pragma once

#include <vector>

#include "compare/truth/lobe_table.h"

namespace lamella {

/// A table for pictures of the mean over a map, and the texels that it is the mean of.
struct TexelTable {
  LobeTable table;
  std::vector<Stack> texels;
};

/// The table of a request: of its texels' mean, if it has any. Up to kMostSolvedTexels different
/// texels have a table each, with the share that they have of the map. Of more of them one in each
/// of 4 x 4 blocks of squares has one, 16 texels in all, no two of a row or a column of squares.
[[nodiscard]] TexelTable table_of_texels(const TruthRequest& request, const StopFlag* stop,
                                         const SolverReport& report = {});

}  // namespace lamella
