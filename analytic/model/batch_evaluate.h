#pragma once

#include "analytic/half_space/lambert_sphere_formula.h"
#include "analytic/half_space/vmf_diffuse_formula.h"
#include "analytic/rough_surface/eon_formula.h"
#include "analytic/rough_surface/oren_nayar_formula.h"
#include "phase/lanes/isa.h"

namespace lamella {

// The formulas that a batch of pairs is evaluated with on lanes of double
// (analytic/model/batch_evaluate.cpp). A formula is a struct of plain numbers with two members over
// any number type:
//   shared(Angles<Real>)        what the colour channels have in common,
//   channel(that, int c)        f [1/sr] of channel c.
// `channels`: 1 (grey: the first is written three times) or 3. `pairs`: x, y, z of w_i and of w_o,
// six numbers per pair; `values`: three per pair, 0 where a direction lies below. Relative
// difference to the same formula in double: see tests/analytic/model/batch_test.cpp.

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

/// DO(name, formula) for each of them.
#define LAMELLA_BATCH_FORMULAS(DO)                 \
  DO(fon_batch, FonFormula)                        \
  DO(eon_batch, EonExactFormula)                   \
  DO(eon_fit_batch, EonFitFormula)                 \
  DO(oren_nayar_batch, OrenNayarFormula)           \
  DO(fujii_batch, FujiiFormula)                    \
  DO(full_oren_nayar_batch, FullOrenNayarFormula)  \
  DO(lambert_sphere_batch, AnalyticLambertSphere)  \
  DO(fast_lambert_sphere_batch, FastLambertSphere) \
  DO(hapke_batch, HapkeLambertSphere)              \
  DO(vmf_diffuse_batch, VmfDiffuseFormula)

LAMELLA_BATCH_FORMULAS(LAMELLA_BATCH_FUNCTION)

#undef LAMELLA_BATCH_FUNCTION

}  // namespace lamella
