#include "compare/judge/stack_comparison.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "compare/judge/judgement.h"

namespace lamella {

StackComparison compare_stack(GroundTruth& truth, const std::vector<BoundModel>& models) {
  StackComparison comparison;
  const std::vector<std::string> names = distinct_names(models);
  for (std::size_t m = 0; m < models.size(); ++m)
    comparison.models.push_back({&models[m], names[m], nanoseconds_per_eval(*models[m].model)});
  for (std::size_t k = 0; truth.goes_on(k); ++k) {
    const Truth found = truth.find(k);
    comparison.runs.push_back(found.run);
    for (JudgedModel& m : comparison.models)
      for (LobeComparison& l : judge(found, truth.plan(), *m.bound))
        m.lobes.push_back(std::move(l));
  }
  std::vector<LobeComparison*> all;
  for (JudgedModel& m : comparison.models)
    for (LobeComparison& l : m.lobes) all.push_back(&l);
  decide(all);
  if (truth.request().stack.grains() && !truth.is_stopped())
    comparison.beside = side_by_side(truth.request(), comparison.runs, truth.stop());
  comparison.choice = truth.choice();
  comparison.channels = truth.plan().channels;
  comparison.interrupted = truth.is_stopped();
  return comparison;
}

double worst_relative_rmse(const StackComparison& comparison) {
  double worst = 0;
  for (const JudgedModel& m : comparison.models)
    for (const LobeComparison& l : m.lobes)
      // Where nothing arrives any model is infinitely far off: that counts once it is no accident.
      // Where walks were cut, what is certain counts.
      if (l.order == Order::all &&
          (std::isfinite(l.relative_rmse_least) || l.verdict == Verdict::differs))
        worst = std::max(worst, l.relative_rmse_least);
  return worst;
}

}  // namespace lamella
