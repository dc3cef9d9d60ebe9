#include "analytic/rough_surface/rough_surface_lanes.h"

#include "analytic/model/batch_lanes.h"

namespace lamella::LAMELLA_ISA {

LAMELLA_ROUGH_SURFACE_FORMULAS(LAMELLA_DEFINE_BATCH_FUNCTION)

}  // namespace lamella::LAMELLA_ISA
