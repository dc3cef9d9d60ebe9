#pragma once

#include "analytic/facets/facet_formula.h"
#include "phase/lanes/isa.h"

namespace lamella {

/// f of pairs of directions: arguments as those of analytic/model/batch_evaluate.h. Pairs with a
/// cosine below FacetFormula::kLeastCosine are left to the caller.
LAMELLA_LANE_FUNCTION(void, facet_batch,
                      (const FacetFormula* formula, int channels, const double* pairs,
                       double* values, std::size_t count))

}  // namespace lamella
