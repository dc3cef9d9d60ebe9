#include "compare/nearest/target_truths.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "compare/exchange/measured_comparison.h"
#include "compare/judge/projection.h"

namespace lamella {
namespace {

constexpr std::array<const char*, kLobeOrders> kNames{"1", "2", "3", "4+", "all", "0", "1+", "2+"};

// A block of the k-th direction as a lobe; empty where the set has none.
LobeEstimate lobe_of(const LobeSet& set, const std::string& side, const std::string& name,
                     std::size_t direction) {
  LobeEstimate lobe;
  const LobeBlock* block = set.lobe(side, name);
  if (!block) return lobe;
  const auto count =
      static_cast<std::size_t>(set.channels) * static_cast<std::size_t>(set.grid.cells());
  const auto part = [&](const std::vector<double>& all) {
    if (all.empty()) return std::vector<double>(count);
    const auto from = all.begin() + static_cast<std::ptrdiff_t>(direction * count);
    return std::vector<double>(from, from + static_cast<std::ptrdiff_t>(count));
  };
  lobe.value = part(block->value);
  lobe.standard_error = part(block->standard_error);
  return lobe;
}

// What stands in the place of a solver's accuracy where the errors are bounds.
DeterministicAccuracy known_accuracy() {
  DeterministicAccuracy accuracy;
  accuracy.reached = true;
  return accuracy;
}

}  // namespace

TargetTruths truths_of(GroundTruth& truth) {
  TargetTruths target{.request = truth.request(),
                      .plan = truth.plan(),
                      .choice = truth.choice(),
                      .truths = {},
                      .interrupted = false};
  for (std::size_t k = 0; truth.goes_on(k); ++k) target.truths.push_back(truth.find(k));
  target.interrupted = truth.is_stopped();
  return target;
}

TargetTruths truths_of(const Model& model, const ModelInfo& info, int channels,
                       TruthRequest request, const RunMonitor& monitor) {
  TargetTruths target{.request = std::move(request),
                      .plan = {},
                      .choice = {Estimator::deterministic, info.doc + " on cells", nullptr},
                      .truths = {},
                      .interrupted = false};
  target.plan.channels = channels;
  target.plan.folded = false;
  target.plan.transmits = info.transmits;
  for (const Direction wi : target.request.directions) {
    if (monitor.is_stopped() && !target.truths.empty()) break;
    target.truths.push_back(projected_truth(model, info, wi, target.request.cells, channels));
  }
  target.interrupted = monitor.is_stopped();
  return target;
}

TargetTruths truths_of(const LobeSet& lobes, const std::string& name) {
  if (!lobes.lobe("reflect", "all") && !lobes.lobe("transmit", "all"))
    throw std::invalid_argument(
        fmt::format("{}: found no lobe \"all\"; allowed: lobes of all orders", name));
  TargetTruths target;
  const auto se = lobes.attributes.find("lamella.se");
  const bool walks = se != lobes.attributes.end() && se->second == "standard error";
  // A projection tells what it left open beyond its tolerance.
  const bool projected = se != lobes.attributes.end() && se->second.starts_with("what the proj");
  target.request.stack.name = name;
  target.request.directions = lobes.directions;
  target.request.cells = lobes.grid;
  target.plan.channels = lobes.channels;
  target.plan.folded = lobes.grid.folded;
  target.plan.transmits = lobes.lobe("transmit", "all") != nullptr;
  target.choice = {walks ? Estimator::analog : Estimator::deterministic, "lobes of a file",
                   nullptr};
  for (std::size_t d = 0; d < lobes.directions.size(); ++d) {
    Truth truth;
    RunResult& run = truth.run;
    run.incident = lobes.directions[d];
    run.estimator = target.choice.estimator;
    run.grid = lobes.grid;
    run.channels = lobes.channels;
    const double solid_angle = run.grid.projected_solid_angle();
    const auto cells = static_cast<std::size_t>(run.grid.cells());
    for (const bool reflected : {true, false}) {
      SideResult& side = reflected ? run.reflected : run.transmitted;
      const std::string word = reflected ? "reflect" : "transmit";
      for (std::size_t o = 0; o < kNames.size(); ++o)
        side.lobes[o] = lobe_of(lobes, word, kNames[o], d);
      for (LobeEstimate& lobe : side.lobes)
        for (std::size_t k = 0; projected && k < lobe.value.size(); ++k)
          lobe.standard_error[k] =
              std::max(lobe.standard_error[k], kProjectionTolerance * std::abs(lobe.value[k]));
      const LobeEstimate& all = side.lobes[Order::all];
      for (std::size_t k = 0; k < all.value.size(); ++k) {
        side.total[k / cells].value += all.value[k] * solid_angle;
        side.total[k / cells].standard_error += all.standard_error[k] * solid_angle;
      }
    }
    for (int c = 0; c < run.channels; ++c)
      run.absorbed[c].value = 1 - run.reflected.total[c].value - run.transmitted.total[c].value;
    if (!walks) run.accuracy = known_accuracy();
    target.truths.push_back(std::move(truth));
  }
  return target;
}

namespace {

// The truths as comparisons take them, and the choice that is told.
struct JudgedTruths {
  std::vector<Truth> own{};
  EstimatorChoice choice;
};

// Walks that are not there themselves: standard errors become bounds. Nothing where all are there.
std::optional<JudgedTruths> as_bounds(const TargetTruths& target) {
  if (std::none_of(target.truths.begin(), target.truths.end(),
                   [](const Truth& t) { return !t.batches && !t.run.is_bounded(); }))
    return std::nullopt;
  JudgedTruths judged{{}, target.choice};
  for (const Truth& truth : target.truths) {
    judged.own.push_back({truth.run, nullptr});
    RunResult& run = judged.own.back().run;
    run.estimator = Estimator::deterministic;
    run.accuracy = known_accuracy();
    for (SideResult* side : {&run.reflected, &run.transmitted})
      for (LobeEstimate& lobe : side->lobes)
        for (double& error : lobe.standard_error) error *= kErrorsAsBound;
  }
  judged.choice.estimator = Estimator::deterministic;
  judged.choice.reason +=
      fmt::format("; {:g} standard errors stand for its bounds", kErrorsAsBound);
  return judged;
}

}  // namespace

StackComparison compare_with(const TargetTruths& target, const std::vector<BoundModel>& models) {
  const std::optional<JudgedTruths> bounded = as_bounds(target);
  StackComparison comparison =
      bounded ? compare_truths(bounded->own, target.plan, bounded->choice, models)
              : compare_truths(target.truths, target.plan, target.choice, models);
  comparison.interrupted = target.interrupted;
  return comparison;
}

StackComparison compare_with(const TargetTruths& target, const BoundModel& model,
                             const LobesOnCells& lobes) {
  const std::optional<JudgedTruths> bounded = as_bounds(target);
  const std::vector<Truth>& truths = bounded ? bounded->own : target.truths;
  StackComparison comparison;
  comparison.choice = bounded ? bounded->choice : target.choice;
  comparison.channels = target.plan.channels;
  comparison.models.push_back({&model, model.info->name, model.info->name});
  std::vector<LobeComparison*> all;
  for (std::size_t k = 0; k < truths.size(); ++k) {
    const Truth& truth = truths[k];
    comparison.runs.push_back(truth.run);
    for (const bool reflected : {true, false}) {
      if (!reflected && !target.plan.transmits) continue;
      for (LobeComparison& l :
           compare(truth.run, truth.batches.get(), lobes(k, reflected), reflected))
        comparison.models[0].lobes.push_back(std::move(l));
    }
  }
  for (LobeComparison& l : comparison.models[0].lobes) all.push_back(&l);
  decide(all);
  comparison.interrupted = target.interrupted;
  return comparison;
}

}  // namespace lamella
