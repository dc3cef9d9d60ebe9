#include "volume/harmonics/circle_sum.h"

#include "volume/harmonics/circle_sum_formulas.h"

namespace lamella {
namespace {

struct OneLane {
  static constexpr int kCount = 1;
  static double load(const double* from) { return *from; }
  static void store(double x, double* to) { *to = x; }
};

}  // namespace

void circle_sum(const CircleTask& task) { circle_sum_of<double, OneLane>(task); }

}  // namespace lamella
