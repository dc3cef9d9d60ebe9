#include "compare/judge/judgement.h"

#include <utility>

#include "compare/judge/projection.h"

namespace lamella {

std::vector<LobeComparison> judge(const Truth& truth, const Plan& plan, const BoundModel& model) {
  const RunResult& run = truth.run;
  std::vector<LobeComparison> lobes;
  for (const bool reflected : {true, false}) {
    if (!reflected && !plan.transmits) continue;
    const bool up = (run.incident.z > 0) == reflected;
    const ProjectedLobes projected =
        project(*model.model, *model.info, run.incident, run.grid, up, run.channels);
    for (LobeComparison& l : compare(run, truth.batches.get(), projected, reflected))
      lobes.push_back(std::move(l));
  }
  return lobes;
}

}  // namespace lamella
