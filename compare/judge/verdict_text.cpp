#include "compare/judge/verdict_text.h"

#include <cmath>

#include "compare/request/percent.h"

namespace lamella {

std::string verdict_text(const LobeComparison& lobe) {
  const double by = lobe.relative_rmse_without_noise;
  if (lobe.verdict != Verdict::differs) return to_text(lobe.verdict);
  return by == 0 || std::isinf(by) ? "differs" : "differs by " + percent_text(by);
}

}  // namespace lamella
