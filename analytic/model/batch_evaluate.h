#pragma once

#include "phase/lanes/isa.h"

namespace lamella {

// The formulas that a batch of pairs is evaluated with on lanes of double
// (analytic/model/batch_lanes.h). A formula is a struct of plain numbers with two members over
// any number type:
//   shared(Angles<Real>)        the terms that the colour channels have in common,
//   channel(that, int c)        f [1/sr] of channel c.
// `channels`: 1 (grey: the first is written three times) or 3. `pairs`: x, y, z of w_i and of w_o,
// six numbers per pair; `values`: three per pair, 0 where a direction lies below. Relative
// difference to the same formula in double: see tests/analytic/model/batch_test.cpp.

template <class Formula>
using BatchFunction = void (*)(const Formula* formula, int channels, const double* pairs,
                               double* values, std::size_t count);

/// Declares a batch function of a formula, `name`, and name_for(isa) that chooses among the sets:
/// in a list LAMELLA_..._FORMULAS(DO) of a family, whose lane source defines them all
/// (half_space_lanes.h and .cpp are an example).
#define LAMELLA_DECLARE_BATCH_FUNCTION(name, Formula)                               \
  LAMELLA_LANE_FUNCTION(void, name,                                                 \
                        (const Formula* formula, int channels, const double* pairs, \
                         double* values, std::size_t count))

}  // namespace lamella
