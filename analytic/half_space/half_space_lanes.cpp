#include "analytic/half_space/half_space_lanes.h"

#include "analytic/model/batch_lanes.h"

namespace lamella::LAMELLA_ISA {

LAMELLA_HALF_SPACE_FORMULAS(LAMELLA_DEFINE_BATCH_FUNCTION)

}  // namespace lamella::LAMELLA_ISA
