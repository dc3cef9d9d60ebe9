// What mirrors scatter twice, along a circle of directions in between, on lanes of double.

#include <hwy/highway.h>

#include "phase/lanes/double_lanes.h"
#include "volume/harmonics/circle_sum_formulas.h"

namespace lamella::LAMELLA_ISA {
namespace {

struct AllLanes {
  static constexpr int kCount = Doubles::kCount;
  LAMELLA_INLINE static Doubles load(const double* from) { return Doubles::load(from); }
  LAMELLA_INLINE static void store(Doubles x, double* to) { x.store(to); }
};
static_assert(kCirclePoints % AllLanes::kCount == 0);

}  // namespace

void circle_sum_lanes(const CircleTask& task) { circle_sum_of<Doubles, AllLanes>(task); }

}  // namespace lamella::LAMELLA_ISA
