#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <limits>
#include <memory>

#include "compare/benchmark.h"
#include "phase/stack_file.h"

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

  [[nodiscard]] std::unique_ptr<Simulation> cells(const std::string& toml, Estimator estimator,
                                                  CellGrid grid) const {
    const Stack stack = parse_stack(toml, "growth", "growth");
    return std::make_unique<Simulation>(stack, plan(stack), benchmark_incident(), estimator, grid,
                                        seed);
  }
  [[nodiscard]] std::unique_ptr<Simulation> points(const std::string& toml, int count) const {
    const Stack stack = parse_stack(toml, "growth", "growth");
    return std::make_unique<Simulation>(stack, plan(stack), benchmark_incident(),
                                        benchmark_points(count), seed);
  }
  [[nodiscard]] Plan plan(const Stack& stack) const {
    Plan result = make_plan(stack);
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
    // The longest walks: how the cost rises as absorption goes, up to the limit of 1000 events.
    grow.rows("absorption", {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6}, [&](double absorption) {
      return grow.cells(sphere_layer(1 - absorption, kInfinity), Estimator::analog,
                        CellGrid{16, 32, true});
    });
  });
}

}  // namespace lamella
