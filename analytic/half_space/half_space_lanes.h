#pragma once

#include "analytic/half_space/lambert_sphere_formula.h"
#include "analytic/half_space/vmf_diffuse_formula.h"
#include "analytic/model/batch_evaluate.h"

namespace lamella {

/// DO(name, formula) for each closed form of a half space that is evaluated on lanes.
#define LAMELLA_HALF_SPACE_FORMULAS(DO)            \
  DO(lambert_sphere_batch, AnalyticLambertSphere)  \
  DO(fast_lambert_sphere_batch, FastLambertSphere) \
  DO(hapke_batch, HapkeLambertSphere)              \
  DO(vmf_diffuse_batch, VmfDiffuseFormula)

LAMELLA_HALF_SPACE_FORMULAS(LAMELLA_DECLARE_BATCH_FUNCTION)

}  // namespace lamella
