#pragma once

#include "analytic/eon_formula.h"
#include "analytic/lambert_sphere_formula.h"
#include "analytic/oren_nayar_formula.h"
#include "analytic/vmf_diffuse_formula.h"
#include "phase/isa.h"

namespace lamella {

// The formulas that a batch of pairs is evaluated with on lanes of double
// (analytic/batch_lanes.cpp). A formula is a struct of plain numbers with two members over any
// number type:
//   shared(Angles<Real>)        what the colour channels have in common,
//   channel(that, int c)        f [1/sr] of channel c.
// `channels`: 1 (grey: the first is written three times) or 3. `pairs`: x, y, z of w_i and of w_o,
// six numbers per pair; `values`: three per pair, 0 where a direction lies below. Relative
// difference to the same formula in double: see tests/analytic/batch_test.cpp.

template <class Formula>
using BatchFunction = void (*)(const Formula* formula, int channels, const double* pairs,
                               double* values, std::size_t count);

#define LAMELLA_BATCH_FUNCTION(name, Formula)                                       \
  LAMELLA_LANE_FUNCTION(void, name,                                                 \
                        (const Formula* formula, int channels, const double* pairs, \
                         double* values, std::size_t count))

using FonFormula = EonFormula<EonAlbedo::none>;
using EonExactFormula = EonFormula<EonAlbedo::exact>;
using EonFitFormula = EonFormula<EonAlbedo::fit>;
using OrenNayarFormula = QualitativeFormula<false>;
using FujiiFormula = QualitativeFormula<true>;

LAMELLA_BATCH_FUNCTION(fon_batch, FonFormula)
LAMELLA_BATCH_FUNCTION(eon_batch, EonExactFormula)
LAMELLA_BATCH_FUNCTION(eon_fit_batch, EonFitFormula)
LAMELLA_BATCH_FUNCTION(oren_nayar_batch, OrenNayarFormula)
LAMELLA_BATCH_FUNCTION(fujii_batch, FujiiFormula)
LAMELLA_BATCH_FUNCTION(full_oren_nayar_batch, FullOrenNayarFormula)
LAMELLA_BATCH_FUNCTION(lambert_sphere_batch, AnalyticLambertSphere)
LAMELLA_BATCH_FUNCTION(fast_lambert_sphere_batch, FastLambertSphere)
LAMELLA_BATCH_FUNCTION(hapke_batch, HapkeLambertSphere)
LAMELLA_BATCH_FUNCTION(vmf_diffuse_batch, VmfDiffuseFormula)

#undef LAMELLA_BATCH_FUNCTION

}  // namespace lamella
