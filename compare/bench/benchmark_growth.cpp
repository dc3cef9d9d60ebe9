#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <limits>
#include <memory>

#include "compare/bench/benchmark.h"
#include "compare/request/stopwatch.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

struct Growing {
  const BenchmarkEffort& effort;
  std::uint64_t seed;
  const ReportRow& report;

  // Seconds per walk of the last of doubling steps, by when what a run costs once is paid.
  [[nodiscard]] double seconds_per_walk(Simulation& simulation) const {
    double step = 0;
    std::uint64_t walks = 16 * kBatches;
    simulation.advance(walks);
    while (step < effort.repetition_seconds)
      step = seconds_of([&] { simulation.advance(walks *= 2); });
    return 2 * step / static_cast<double>(walks);
  }

  // make(size) is the simulation of that size; rows tell how cost grows from one to the next.
  template <class Make>
  void rows(const std::string& what, const std::vector<double>& sizes, Make make) const {
    double before = 0, size_before = 0;
    for (const double size : sizes) {
      const std::unique_ptr<Simulation> simulation = make(size);
      const double seconds = seconds_per_walk(*simulation);
      BenchmarkRow row{.what = fmt::format("growth of walks/{} {:g}", what, size), .kind = "walk"};
      row.seconds = seconds;
      row.collisions_per_second_per_core = static_cast<double>(simulation->collisions()) /
                                           (seconds * static_cast<double>(simulation->walks()));
      if (before > 0)
        row.extra["exponent"] = std::log(seconds / before) / std::log(size / size_before);
      before = seconds;
      size_before = size;
      report(std::move(row));
    }
  }

  // Seconds to an error of 1 % of the cells, by time x variance.
  [[nodiscard]] double seconds_to_a_percent(Simulation& simulation) const {
    const double taken = advance_for(simulation, effort.accuracy_seconds);
    const double error = noise_of(reduce(simulation).reflected.lobes[Order::all]);
    return taken * error * error * 1e4;
  }

  // The longest walks: how the cost of an error rises as absorption goes, with thinning and
  // without. make(absorption, limits) is the simulation.
  template <class Make>
  void absorption_rows(const std::vector<double>& absorptions, Make make) const {
    double before = 0, absorption_before = 0;
    for (const double absorption : absorptions) {
      const std::unique_ptr<Simulation> simulation = make(absorption, WalkLimits{});
      const Plan& planned = simulation->plan();
      const double seconds = seconds_to_a_percent(*simulation);
      BenchmarkRow row{.what = fmt::format("growth of cost/absorption {:g}", absorption),
                       .kind = "walk"};
      row.seconds = seconds;
      row.error = 0.01;
      if (const auto use = simulation->lane_use()) {
        row.extra["lane_occupancy"] = use->occupancy;
        row.extra["null_collisions"] = use->null;
      }
      if (planned.thinning.is_on()) {
        const auto plain =
            make(absorption, WalkLimits{.max_order = planned.max_order, .thinning = Thinning{}});
        row.baseline = fmt::format("walks that are not thinned, to {} events", planned.max_order);
        row.ratio_to_baseline = seconds_to_a_percent(*plain) / seconds;
      }
      if (before > 0)
        row.extra["exponent"] =
            std::log(seconds / before) / std::log(absorption / absorption_before);
      before = seconds;
      absorption_before = absorption;
      report(std::move(row));
    }
  }

  [[nodiscard]] std::unique_ptr<Simulation> cells(const std::string& toml, Estimator estimator,
                                                  CellGrid grid,
                                                  const WalkLimits& limits = {}) const {
    const Stack stack = parse_stack(toml, "growth", "growth");
    return std::make_unique<Simulation>(stack, plan(stack, limits), benchmark_incident(), estimator,
                                        grid, seed);
  }
  [[nodiscard]] std::unique_ptr<Simulation> points(const std::string& toml, int count) const {
    const Stack stack = parse_stack(toml, "growth", "growth");
    return std::make_unique<Simulation>(stack, plan(stack), benchmark_incident(),
                                        benchmark_points(count), seed);
  }
  [[nodiscard]] Plan plan(const Stack& stack, const WalkLimits& limits = {}) const {
    Plan result = make_plan(stack, limits);
    result.isa = effort.isa;
    return result;
  }
};

std::string sphere_layer(double albedo, double thickness) {
  return fmt::format("[[layer]]\nmedium = \"lambert_sphere\"\nalbedo = {}\nthickness = {}\n",
                     albedo, to_text(thickness));
}

}  // namespace

void measure_growth_of_walks(const BenchmarkEffort& effort, std::uint64_t seed,
                             const ReportRow& report) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Growing grow{effort, seed, report};
  const std::string half_space = sphere_layer(0.9, kInfinity);
  const auto square = [](double rows) {
    return CellGrid{static_cast<int>(rows), 2 * static_cast<int>(rows), true};
  };
  tbb::task_arena one(1);
  one.execute([&] {
    // One slab of depth 4 in equal parts that differ a little in albedo, so that none are joined.
    grow.rows("layers", {1, 4, 16, 64}, [&](double n) {
      std::string toml;
      for (int k = 0; k < static_cast<int>(n); ++k) toml += sphere_layer(0.9 + 1e-6 * k, 4 / n);
      return grow.cells(toml, Estimator::analog, CellGrid{16, 32, true});
    });
    grow.rows("optical depth", {1, 8, 64, 512}, [&](double depth) {
      return grow.cells(sphere_layer(1, depth), Estimator::analog, CellGrid{16, 32, true});
    });
    grow.rows("cells, analog", {8, 32, 128},
              [&](double rows) { return grow.cells(half_space, Estimator::analog, square(rows)); });
    grow.rows("cells, next-event", {8, 32, 128}, [&](double rows) {
      return grow.cells(half_space, Estimator::next_event, square(rows));
    });
    grow.rows("directions", {1, 4, 16, 64},
              [&](double n) { return grow.points(half_space, static_cast<int>(n)); });
    grow.absorption_rows({1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6},
                         [&](double absorption, const WalkLimits& limits) {
                           return grow.cells(sphere_layer(1 - absorption, kInfinity),
                                             Estimator::analog, CellGrid{16, 32, true}, limits);
                         });
  });
}

}  // namespace lamella
