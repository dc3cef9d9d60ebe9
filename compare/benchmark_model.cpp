#include <cmath>

#include "compare/benchmark.h"
#include "compare/model_request.h"
#include "phase/builtin_stacks.h"

namespace lamella {
namespace {

constexpr int kPairs = 64;

// A value for a parameter that has no default: the middle of its range.
std::optional<ParameterValue> middle_of(const ParameterInfo& info) {
  const double low = std::isfinite(info.min) ? info.min : 0;
  const double high = std::isfinite(info.max) ? info.max : low + 1;
  const double middle = (low + high) / 2;
  switch (info.kind) {
    case ParameterKind::number:
      return middle;
    case ParameterKind::color:
      return Rgb(middle);
    case ParameterKind::vector:
      return std::vector<double>{0, 0, 1};
    case ParameterKind::choice:
      return info.choices.front();
    default:
      return std::nullopt;
  }
}

// The model with its defaults; what has none is taken from the first built-in stack that the model
// applies to, or else from the middle of its range. Nothing if it cannot be built so.
std::unique_ptr<Model> default_model(const ModelInfo& info, const Stack& stack) {
  Parameters parameters;
  fill_defaults(info.parameters, parameters);
  const auto lacks = [&](const ParameterInfo& p) { return !parameters.has(p.name); };
  if (std::any_of(info.parameters.begin(), info.parameters.end(), lacks)) {
    if (info.applies_to)
      for (const BuiltinStack& builtin : builtin_stacks())
        if (const auto found = info.applies_to(load_stack(builtin.name))) {
          for (const auto& [key, value] : found->all()) parameters.set(key, value);
          break;
        }
    for (const ParameterInfo& p : info.parameters)
      if (const auto value = lacks(p) ? middle_of(p) : std::nullopt) parameters.set(p.name, *value);
  }
  try {
    return info.make(parameters, &stack);
  } catch (const ParameterError&) {
    return nullptr;
  }
}

}  // namespace

void measure_models(const BenchmarkEffort& effort, const ReportRow& report) {
  const Stack stack = load_stack(std::string(kDefaultStack));
  std::vector<DirectionPair> pairs;
  RandomStream stream(1, 0, StreamPurpose::test);
  const auto draw = [&] {
    const double mu = stream.uniform();
    return direction_from_mu_phi(mu, 2 * kPi * stream.uniform());
  };
  for (int k = 0; k < kPairs; ++k) {
    const Direction wi = draw();
    pairs.push_back({wi, draw()});
  }
  std::vector<Rgb> values(kPairs);
  for (const ModelInfo& info : models()) {
    const auto model = default_model(info, stack);
    if (!model) continue;
    volatile double sink = 0;  // keeps the loops
    const auto single = [&](int rounds) {
      double sum = 0;
      for (int k = 0; k < rounds; ++k)
        for (const DirectionPair& pair : pairs) sum += model->eval(pair.wi, pair.wo).g;
      sink = sum;
    };
    const auto batch = [&](int rounds) {
      double sum = 0;
      for (int k = 0; k < rounds; ++k) {
        model->eval(pairs, values);
        sum += values[static_cast<std::size_t>(k) % kPairs].g;
      }
      sink = sum;
    };
    int rounds = 1;
    while (rounds < 1 << 20 && seconds_of([&] { single(rounds); }) < effort.evaluation_seconds / 2)
      rounds *= 2;
    const InterleavedTimes times = interleave(
        effort.repetitions, [&] { batch(rounds); }, [&] { single(rounds); });
    const auto nanoseconds = [&](const std::vector<double>& seconds) {
      return *std::min_element(seconds.begin(), seconds.end()) * 1e9 / rounds / kPairs;
    };
    BenchmarkRow one{.what = "eval/" + info.name, .kind = "closed_form"};
    one.ns_per_eval = nanoseconds(times.second);
    report(std::move(one));
    BenchmarkRow many{.what = "eval_batch/" + info.name, .kind = "closed_form"};
    many.ns_per_eval = nanoseconds(times.first);
    many.baseline = "single calls";
    many.ratio_to_baseline = times.median_ratio();
    many.extra = {{"batch", kPairs}};
    report(std::move(many));
  }
}

}  // namespace lamella
