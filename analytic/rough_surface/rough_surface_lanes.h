#pragma once

#include "analytic/model/batch_evaluate.h"
#include "analytic/rough_surface/eon_formula.h"
#include "analytic/rough_surface/oren_nayar_formula.h"

namespace lamella {

using FonFormula = EonFormula<EonAlbedo::none>;
using EonExactFormula = EonFormula<EonAlbedo::exact>;
using EonFitFormula = EonFormula<EonAlbedo::fit>;
using OrenNayarFormula = QualitativeFormula<false>;
using FujiiFormula = QualitativeFormula<true>;

/// DO(name, formula) for each closed form of a rough surface that is evaluated on lanes.
#define LAMELLA_ROUGH_SURFACE_FORMULAS(DO) \
  DO(fon_batch, FonFormula)                \
  DO(eon_batch, EonExactFormula)           \
  DO(eon_fit_batch, EonFitFormula)         \
  DO(oren_nayar_batch, OrenNayarFormula)   \
  DO(fujii_batch, FujiiFormula)            \
  DO(full_oren_nayar_batch, FullOrenNayarFormula)

LAMELLA_ROUGH_SURFACE_FORMULAS(LAMELLA_DECLARE_BATCH_FUNCTION)

}  // namespace lamella
