#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "compare/bench/benchmark.h"
#include "compare/request/stopwatch.h"
#include "phase/stack/stack_file.h"
#include "volume/run/simulation.h"

namespace lamella {
namespace {

struct MixedMedium {
  const char *name, *toml;
};
constexpr MixedMedium kSphere{"lambert_sphere", "medium = \"lambert_sphere\"\n"};
constexpr MixedMedium kHenyeyGreenstein{"henyey_greenstein",
                                        "medium = \"henyey_greenstein\"\ng = 0.7\n"};
constexpr MixedMedium kSggx{"sggx", "medium = \"sggx\"\nroughness = 0.5\n"};
constexpr MixedMedium kVmf{"vmf_flake",
                           "medium = \"vmf_flake\"\nflake = \"lambert\"\nroughness = 0.5\n"};

Stack stack_of(const std::vector<MixedMedium>& media, const std::string& name) {
  std::string toml;
  for (const MixedMedium& medium : media)
    toml += fmt::format("[[layer]]\n{}albedo = 0.9\nthickness = 1\n", medium.toml);
  return parse_stack(toml, name, name);
}

// Walks with cells, by their seconds per collision.
class TimedWalks {
 public:
  TimedWalks(const Stack& stack, Isa isa, std::uint64_t seed,
             LayerTurns turns = LayerTurns::where_faster)
      : plan_(make_plan(stack)) {
    plan_.isa = isa;
    plan_.layer_turns = turns;
    walks_ = std::make_unique<Simulation>(stack, plan_, benchmark_incident(), Estimator::analog,
                                          CellGrid{}, seed);
  }
  double seconds_per_collision(double seconds) {
    constexpr std::uint64_t kStep = 64 * kBatches;
    std::uint64_t step = kStep;
    for (;;) {
      const std::uint64_t before = walks_->collisions();
      const double taken = seconds_of([&] { walks_->advance(walks_->walks() + step); });
      if (taken >= seconds) return taken / static_cast<double>(walks_->collisions() - before);
      step *= 2;
    }
  }
  [[nodiscard]] const Simulation& simulation() const { return *walks_; }

 private:
  Plan plan_;
  std::unique_ptr<Simulation> walks_;
};

// Stacks of several media, beside those of each medium alone, and beside lanes each in its own
// layer.
void measure(const std::vector<MixedMedium>& media, const BenchmarkEffort& effort,
             std::uint64_t seed, const ReportRow& report) {
  std::string name;
  std::vector<TimedWalks> alone;
  for (const MixedMedium& medium : media) {
    name += (name.empty() ? "mixed/" : "+") + std::string(medium.name);
    const std::vector<MixedMedium> same(media.size(), medium);
    alone.emplace_back(stack_of(same, medium.name), effort.isa, seed);
  }
  TimedWalks mixed(stack_of(media, name), effort.isa, seed);
  TimedWalks apart(stack_of(media, name), effort.isa, seed, LayerTurns::never);
  double sum = 0, sum_alone = 0, sum_apart = 0;
  for (int k = 0; k < effort.repetitions; ++k) {
    sum += mixed.seconds_per_collision(effort.repetition_seconds);
    sum_apart += apart.seconds_per_collision(effort.repetition_seconds);
    for (TimedWalks& walks : alone)
      sum_alone += walks.seconds_per_collision(effort.repetition_seconds) /
                   static_cast<double>(alone.size());
  }
  const auto row_of = [&](const TimedWalks& walks, double taken) {
    BenchmarkRow row{.what = name, .kind = "walk"};
    row.seconds = taken / effort.repetitions * static_cast<double>(walks.simulation().collisions());
    row.collisions_per_second_per_core = effort.repetitions / taken;
    row.extra = {{"walks", walks.simulation().walks()}, {"isa", to_text(walks.simulation().isa())}};
    return row;
  };
  BenchmarkRow row = row_of(mixed, sum);
  row.baseline = "the mean of stacks of each medium alone, as many layers";
  row.ratio_to_baseline = sum_alone / sum;
  report(std::move(row));
  BenchmarkRow turns = row_of(mixed, sum);
  turns.what += ", in turns";
  turns.baseline = "lanes each in its own layer";
  turns.ratio_to_baseline = sum_apart / sum;
  report(std::move(turns));
}

}  // namespace

void measure_mixed(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report) {
  tbb::task_arena one(1);
  const std::vector<std::vector<MixedMedium>> stacks{{kSphere, kHenyeyGreenstein},
                                                     {kSphere, kSggx},
                                                     {kSphere, kVmf},
                                                     {kSggx, kVmf},
                                                     {kSphere, kHenyeyGreenstein, kSggx, kVmf}};
  for (const auto& media : stacks) one.execute([&] { measure(media, effort, seed, report); });
}

}  // namespace lamella
