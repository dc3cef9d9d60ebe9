#include "compare/judge/stack_comparison.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "compare/judge/judgement.h"

namespace lamella {

namespace {

// With the models and the time that each takes.
StackComparison comparison_of(const std::vector<BoundModel>& models) {
  StackComparison comparison;
  const std::vector<std::string> names = distinct_names(models), labels = distinct_labels(models);
  for (std::size_t m = 0; m < models.size(); ++m)
    comparison.models.push_back(
        {&models[m], names[m], labels[m], nanoseconds_per_eval(*models[m].model)});
  return comparison;
}

void add_truth(StackComparison& comparison, const Truth& truth, const Plan& plan) {
  comparison.runs.push_back(truth.run);
  if (truth.map_error) comparison.map_errors.push_back(*truth.map_error);
  for (JudgedModel& m : comparison.models)
    for (LobeComparison& l : judge(truth, plan, *m.bound)) m.lobes.push_back(std::move(l));
}

void decide_all(StackComparison& comparison) {
  std::vector<LobeComparison*> all;
  for (JudgedModel& m : comparison.models)
    for (LobeComparison& l : m.lobes) all.push_back(&l);
  decide(all);
}

}  // namespace

StackComparison compare_stack(GroundTruth& truth, const std::vector<BoundModel>& models) {
  StackComparison comparison = comparison_of(models);
  for (std::size_t k = 0; truth.goes_on(k); ++k) add_truth(comparison, truth.find(k), truth.plan());
  decide_all(comparison);
  // A surface is no bed: no medium stands for it.
  const GrainGeometry* grains = truth.request().stack.grains();
  if (grains && !grains->is_height_field() && !truth.is_stopped())
    comparison.beside = side_by_side(truth.request(), comparison.runs, truth.stop());
  comparison.choice = truth.choice();
  comparison.texel_ends = truth.texel_ends();
  comparison.channels = truth.plan().channels;
  comparison.interrupted = truth.is_stopped();
  return comparison;
}

StackComparison compare_truths(const std::vector<Truth>& truths, const Plan& plan,
                               const EstimatorChoice& choice,
                               const std::vector<BoundModel>& models) {
  StackComparison comparison = comparison_of(models);
  for (const Truth& truth : truths) add_truth(comparison, truth, plan);
  decide_all(comparison);
  comparison.choice = choice;
  comparison.channels = plan.channels;
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
