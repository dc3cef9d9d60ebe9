#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "compare/bench/benchmark.h"
#include "compare/bench/textbook_models.h"
#include "compare/request/model_request.h"
#include "compare/request/stack_parameters.h"
#include "compare/request/stopwatch.h"
#include "phase/stack/builtin_stacks.h"

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
    case ParameterKind::one_or_two:
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
// applies to, or else from the middle of its range. Without a model if it cannot be built so.
BoundModel default_model(const ModelInfo& info, const Stack& stack) {
  BoundModel bound{.info = &info, .parameters = {}, .model = nullptr};
  Parameters& parameters = bound.parameters;
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
    bound.model = info.make(parameters, &stack);
  } catch (const ParameterError&) {
    bound.model = nullptr;
  }
  return bound;
}

std::vector<DirectionPair> random_pairs() {
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
  return pairs;
}

// Single calls, batches and the textbook version of one model, interleaved.
class ModelTimer {
 public:
  ModelTimer(const Model& model, const TextbookModel* textbook, Isa isa)
      : model_(model), textbook_(textbook), isa_(isa), values_(kPairs), grey_(kPairs) {}

  void measure(const BenchmarkEffort& effort) {
    while (rounds_ < 1 << 20 && seconds_of([&] { single(); }) < effort.evaluation_seconds / 2)
      rounds_ *= 2;
    for (int k = 0; k < effort.repetitions; ++k) {
      batches.push_back(seconds_of([&] { batch(); }));
      singles.push_back(seconds_of([&] { single(); }));
      if (textbook_) textbooks.push_back(seconds_of([&] { textbook(); }));
    }
  }
  /// Nanoseconds per evaluation of the fastest repetition.
  [[nodiscard]] double nanoseconds(const std::vector<double>& seconds) const {
    return *std::min_element(seconds.begin(), seconds.end()) * 1e9 / rounds_ / kPairs;
  }
  std::vector<double> batches, singles, textbooks;  ///< seconds per repetition

 private:
  void single() {
    double sum = 0;
    for (int k = 0; k < rounds_; ++k)
      for (const DirectionPair& pair : pairs_) sum += model_.eval(pair.wi, pair.wo).g;
    sink_ = sum;
  }
  void batch() {
    double sum = 0;
    for (int k = 0; k < rounds_; ++k) {
      model_.eval(pairs_, values_, isa_);
      sum += values_[static_cast<std::size_t>(k) % kPairs].g;
    }
    sink_ = sum;
  }
  void textbook() {
    double sum = 0;
    for (int k = 0; k < rounds_; ++k) {
      textbook_->eval(pairs_, grey_);
      sum += grey_[static_cast<std::size_t>(k) % kPairs];
    }
    sink_ = sum;
  }

  const Model& model_;
  const TextbookModel* textbook_;
  Isa isa_;
  std::vector<DirectionPair> pairs_ = random_pairs();
  std::vector<Rgb> values_;
  std::vector<double> grey_;
  int rounds_ = 1;
  volatile double sink_ = 0;  // keeps the loops
};

}  // namespace

void measure_models(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report) {
  const Stack stack = load_stack(std::string(kDefaultStack));
  struct Judged {
    JudgedClosedForm form;
    std::string stack;
  };
  std::map<std::string, Judged> judged;
  tbb::task_arena one(1);
  for (const BenchmarkStack& entry : benchmark_stacks()) {
    const Stack claimed = load_stack(entry.name);
    const auto is_new = [&](const BoundModel& b) { return !judged.contains(b.info->name); };
    const std::vector<BoundModel> claimants = models_for({}, claimed);
    if (std::none_of(claimants.begin(), claimants.end(), is_new)) continue;
    for (JudgedClosedForm& form :
         one.execute([&] { return judged_closed_forms(claimed, effort, seed); })) {
      const std::string name = form.bound.info->name;
      judged.try_emplace(name, Judged{std::move(form), entry.name});
    }
  }
  for (const ModelInfo& info : models()) {
    const auto found = judged.find(info.name);
    BoundModel made;
    if (found == judged.end()) made = default_model(info, stack);
    const BoundModel& bound = found == judged.end() ? made : found->second.form.bound;
    if (!bound.model) continue;
    const auto textbook = textbook_model(info.name, bound.parameters);
    ModelTimer timer(*bound.model, textbook.get(), effort.isa);
    timer.measure(effort);
    const auto row = [&](const char* how, const std::vector<double>& seconds) {
      BenchmarkRow r{.what = how + info.name, .kind = "closed_form"};
      r.ns_per_eval = timer.nanoseconds(seconds);
      if (found != judged.end()) {
        const ClosedFormError& e = found->second.form.error;
        r.error = e.error > 0 ? e.error : e.high;
        r.extra["error_on"] = found->second.stack;
      }
      if (textbook) {
        r.baseline = "textbook scalar code";
        r.ratio_to_baseline = InterleavedTimes{seconds, timer.textbooks}.median_ratio();
        r.extra["ns_textbook"] = timer.nanoseconds(timer.textbooks);
      }
      return r;
    };
    report(row("eval/", timer.singles));
    BenchmarkRow many = row("eval_batch/", timer.batches);
    if (!textbook) {
      many.baseline = "single calls";
      many.ratio_to_baseline = InterleavedTimes{timer.batches, timer.singles}.median_ratio();
    }
    many.extra["batch"] = kPairs;
    many.extra["isa"] = to_text(effort.isa);
    report(std::move(many));
  }
}

}  // namespace lamella
