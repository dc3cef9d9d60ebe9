#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <limits>

#include "compare/bench/benchmark.h"
#include "compare/bench/lane_sorting.h"
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
  TimedWalks(const Stack& stack, Isa isa, std::uint64_t seed) : plan_(make_plan(stack)) {
    plan_.isa = isa;
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

// Returns what masks cost: seconds per collision beyond those of each medium alone.
double measure(const std::vector<MixedMedium>& media, const BenchmarkEffort& effort,
               std::uint64_t seed, const ReportRow& report) {
  std::string name;
  std::vector<TimedWalks> alone;
  for (const MixedMedium& medium : media) {
    name += (name.empty() ? "mixed/" : "+") + std::string(medium.name);
    const std::vector<MixedMedium> same(media.size(), medium);
    alone.emplace_back(stack_of(same, medium.name), effort.isa, seed);
  }
  TimedWalks mixed(stack_of(media, name), effort.isa, seed);
  double sum = 0, sum_alone = 0;
  for (int k = 0; k < effort.repetitions; ++k) {
    sum += mixed.seconds_per_collision(effort.repetition_seconds);
    for (TimedWalks& walks : alone)
      sum_alone += walks.seconds_per_collision(effort.repetition_seconds) /
                   static_cast<double>(alone.size());
  }
  BenchmarkRow row{.what = name, .kind = "walk"};
  row.seconds = sum / effort.repetitions * static_cast<double>(mixed.simulation().collisions());
  row.collisions_per_second_per_core = effort.repetitions / sum;
  row.baseline = "the mean of stacks of each medium alone, as many layers";
  row.ratio_to_baseline = sum_alone / sum;
  row.extra = {{"walks", mixed.simulation().walks()}, {"isa", to_text(mixed.simulation().isa())}};
  report(std::move(row));
  return (sum - sum_alone) / effort.repetitions;
}

// What it would cost to have lanes sorted by medium instead: to move walks whenever that changes.
void measure_sorting(const BenchmarkEffort& effort, double masks, const ReportRow& report) {
  const auto sort = sort_walks_for(effort.isa);
  if (!sort) return;
  const double walks = sorted_walks_for(effort.isa)();
  double best = std::numeric_limits<double>::infinity();
  for (int k = 0; k < effort.repetitions; ++k) {
    std::uint32_t steps = 1024, sum = 0;
    double taken = 0;
    while (taken < effort.repetition_seconds) taken = seconds_of([&] { sum += sort(steps *= 2); });
    if (sum == 1) return;  // which it is not: what is summed has been moved
    best = std::min(best, taken / (steps * walks));
  }
  BenchmarkRow row{.what = "mixed/sorting two media, per walk and step", .kind = "walk"};
  row.seconds = best;
  row.baseline = "what masks cost two media per collision";
  row.ratio_to_baseline = std::max(0.0, masks) / best;
  row.extra["isa"] = to_text(effort.isa);
  report(std::move(row));
}

}  // namespace

void measure_mixed(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report) {
  tbb::task_arena one(1);
  const std::vector<std::vector<MixedMedium>> stacks{{kSphere, kHenyeyGreenstein},
                                                     {kSphere, kSggx},
                                                     {kSphere, kVmf},
                                                     {kSggx, kVmf},
                                                     {kSphere, kHenyeyGreenstein, kSggx, kVmf}};
  double masks = 0;
  int pairs = 0;
  for (const auto& media : stacks)
    one.execute([&] {
      const double cost = measure(media, effort, seed, report);
      if (media.size() == 2) {
        masks += cost;
        ++pairs;
      }
    });
  one.execute([&] { measure_sorting(effort, masks / pairs, report); });
}

}  // namespace lamella
