#include <tbb/task_arena.h>

#include <cmath>

#include "compare/bench/benchmark.h"
#include "compare/bench/walk_trial.h"
#include "compare/request/stopwatch.h"
#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"
#include "volume/grid_walk/grid_march.h"
#include "volume/voxels/density_grid.h"

namespace lamella {
namespace {

// Tiles of 96^3 voxels: a few dense balls in empty space, and density everywhere.
struct GridCase {
  const char* name;
  double density;  // of the layer [1/mm]
  std::shared_ptr<const Voxels> voxels;
};

std::shared_ptr<const Voxels> balls() {
  constexpr int n = 96, count = 12;
  constexpr double radius = 9;
  Voxels out(VoxelExtent{{n, n, n}});
  RandomStream stream(1, 0, StreamPurpose::test);
  for (int k = 0; k < count; ++k) {
    const double x = n * stream.uniform(), y = n * stream.uniform();
    const double z = radius + (n - 2 * radius) * stream.uniform();
    VoxelIndex i;
    for (i[2] = static_cast<int>(z - radius); i[2] <= z + radius && i[2] < n; ++i[2])
      for (int b = -10; b <= 10; ++b)
        for (int a = -10; a <= 10; ++a) {
          const double cx = std::floor(x) + a, cy = std::floor(y) + b;
          if (std::hypot(cx + 0.5 - x, cy + 0.5 - y, i[2] + 0.5 - z) > radius) continue;
          i[0] = (static_cast<int>(cx) + n) % n;
          i[1] = (static_cast<int>(cy) + n) % n;
          out.density.set(i, {1});
        }
  }
  return std::make_shared<const Voxels>(std::move(out));
}

std::shared_ptr<const Voxels> everywhere() {
  constexpr int n = 96;
  Voxels out(VoxelExtent{{n, n, n}});
  for_each_voxel(out.extent(), [&](VoxelIndex i) {
    const auto wave = [&](int k) { return std::sin(2 * kPi * (k + 1) * i[k] / n); };
    out.density.set(i, {static_cast<float>(1 + 0.5 * wave(0) * wave(1) + 0.3 * wave(2))});
  });
  return std::make_shared<const Voxels>(std::move(out));
}

Stack stack_of(const GridCase& which) {
  return parse_stack(
      "[[layer]]\nmedium = \"henyey_greenstein\"\nalbedo = 0.9\nthickness = 1\n"
      "grid = \"" +
          std::string(which.name) + "\"\nsize = [1, 1]\ndensity = " + to_text(which.density) + "\n",
      "<bench>", which.name);
}

Plan plan_of(const Stack& stack, const GridCase& which, MajorantCells cells) {
  return make_plan(stack, {},
                   {std::make_shared<const DensityGrid>(stack.layers[0], which.voxels, cells)});
}

// The march that a first version has: half a voxel at a time, density looked up at each, a
// collision where the sum passes the exponential number. Isotropic scattering of albedo 0.9.
class FixedStepWalk {
 public:
  FixedStepWalk(const DensityGrid& grid, Direction wi, std::uint64_t seed)
      : grid_(grid), wi_(wi), seed_(seed), reflected_(kBatches), walks_in_(kBatches) {}

  void advance(std::uint64_t count) {
    for (const std::uint64_t to = walks_ + count; walks_ < to; ++walks_) {
      reflected_[walks_ % kBatches] += walk();
      ++walks_in_[walks_ % kBatches];
    }
  }
  [[nodiscard]] Estimate reflected() const {
    double sum = 0, variance = 0;
    for (const double r : reflected_) sum += r;
    const double mean = sum / static_cast<double>(walks_);
    for (int b = 0; b < kBatches; ++b) {
      const double excess = reflected_[b] - mean * walks_in_[b];
      variance += excess * excess;
    }
    return {mean, std::sqrt(variance * kBatches / (kBatches - 1)) / static_cast<double>(walks_)};
  }

 private:
  [[nodiscard]] double walk() {
    RandomStream stream(seed_, walks_, StreamPurpose::test);
    const VoxelIndex n = grid_.extent().voxels;
    const Direction h = grid_.voxel_size();
    const double step = 0.5 * std::min({h.x, h.y, h.z});
    double p[3] = {n[0] * stream.uniform(), n[1] * stream.uniform(), wi_.z > 0 ? 1.0 * n[2] : 0.0};
    Direction d = -wi_;
    double weight = 1;
    for (int order = 0;; ++order) {
      double remaining = stream.exponential();
      const double rate[3] = {d.x / h.x * step, d.y / h.y * step, d.z / h.z * step};
      while (remaining > 0) {
        for (int a = 0; a < 3; ++a) {
          p[a] += rate[a];
          if (a < 2) p[a] -= n[a] * std::floor(p[a] / n[a]);
        }
        if (p[2] >= n[2]) return order > 0 ? weight : 0;
        if (p[2] < 0) return 0;
        const VoxelIndex i{std::min(static_cast<int>(p[0]), n[0] - 1),
                           std::min(static_cast<int>(p[1]), n[1] - 1), static_cast<int>(p[2])};
        remaining -= grid_.layer_density() * grid_.density(i) * step;
      }
      // As the engine's: the weight to the fourth event, then survival.
      if (order < kTallyOrders - 1)
        weight *= 0.9;
      else if (stream.uniform() >= 0.9)
        return 0;
      const double u1 = stream.uniform(), u2 = stream.uniform();
      d = uniform_sphere(u1, u2);
    }
  }

  const DensityGrid& grid_;
  Direction wi_;
  std::uint64_t seed_, walks_ = 0;
  std::vector<double> reflected_, walks_in_;
};

Estimate reflected(const Simulation& simulation) {
  return batch_estimate(simulation.batches(), [](const BatchTally& b) {
    double sum = 0;
    for (const auto& order : b.energy.up) sum += order[0];
    return sum;
  });
}

Estimate at_point(const Simulation& simulation) {
  return batch_estimate(simulation.batches(), [](const BatchTally& b) {
    double sum = 0;
    for (const double f : b.f) sum += f;
    return sum;
  });
}

void measure_grid(const GridCase& which, const BenchmarkEffort& effort, std::uint64_t seed,
                  const ReportRow& report) {
  const Stack stack = stack_of(which);
  const Direction wi = benchmark_incident();
  const Plan cells = plan_of(stack, which, MajorantCells::adaptive);
  const Plan blocks = plan_of(stack, which, MajorantCells::blocks);
  const Plan global = plan_of(stack, which, MajorantCells::global);
  const auto on = [](Simulation& s, std::uint64_t n) { s.advance(s.walks() + n); };

  const auto row_of = [&](const Simulation& simulation, const std::string& task,
                          const InterleavedTimes& times, std::uint64_t collisions, Estimate e) {
    BenchmarkRow row{.what = std::string("grid_") + which.name + "/" + task, .kind = "walk"};
    row.seconds = times.total_first();
    row.collisions_per_second_per_core = static_cast<double>(collisions) / times.total_first();
    row.error = e.standard_error / e.value;
    row.extra = {{"walks", simulation.walks()}};
    return row;
  };

  // Time x variance of the marcher against other cuts of space, and against fixed steps.
  for (const auto& [plan, name, suffix] :
       {std::tuple{&global, "one majorant for the whole grid", ""},
        std::tuple{&blocks, "a majorant per block of 8^3 voxels, none merged", ", per block"}})
    for (const bool next_event : {false, true}) {
      const std::vector<Direction> points =
          next_event ? benchmark_points(1) : std::vector<Direction>();
      Simulation ours(stack, cells, wi, points, seed), theirs(stack, *plan, wi, points, seed + 1);
      const std::uint64_t walks = walks_for(effort.repetition_seconds, ours);
      on(theirs, walks);
      const std::uint64_t before = ours.collisions();
      const InterleavedTimes times = interleave(
          effort.repetitions, [&] { on(ours, walks); }, [&] { on(theirs, walks); });
      const Estimate e = next_event ? at_point(ours) : reflected(ours);
      const Estimate other = next_event ? at_point(theirs) : reflected(theirs);
      // Analog walks have the same variance however space is cut; ratio tracking has not.
      const double variance_ratio =
          next_event ? variance_per_walk(other, theirs.walks()) / variance_per_walk(e, ours.walks())
                     : 1;
      BenchmarkRow row = row_of(ours, std::string(next_event ? "nee1" : "walk") + suffix, times,
                                ours.collisions() - before, e);
      row.baseline = name;
      row.ratio_to_baseline = times.median_ratio() * variance_ratio;
      row.extra["variance_ratio"] = variance_ratio;
      report(std::move(row));
    }
  Simulation ours(stack, cells, wi, std::vector<Direction>(), seed);
  FixedStepWalk steps(*cells.grids[0], wi, seed);
  const std::uint64_t walks = walks_for(effort.repetition_seconds, ours);
  const std::uint64_t before = ours.collisions();
  const InterleavedTimes times = interleave(
      effort.repetitions, [&] { on(ours, walks); }, [&] { steps.advance(walks); });
  const Estimate e = reflected(ours), other = steps.reflected();
  BenchmarkRow row = row_of(ours, "fixed steps", times, ours.collisions() - before, e);
  const double bias = other.value / e.value - 1;
  row.baseline =
      "fixed steps of half a voxel, whose reflected energy is off by " +
      to_text(std::round(1e4 * bias) / 100) + " % +- " +
      to_text(std::round(1e4 * std::hypot(other.standard_error, e.standard_error) / e.value) / 100);
  row.ratio_to_baseline = times.median_ratio();
  report(std::move(row));
}

// The part of the mean square of a shadow ray's transmittance that its own chance is, over places
// and directions: what an exact transmittance would save.
void measure_ray_variance(const char* name, const BenchmarkEffort& effort, std::uint64_t seed,
                          const ReportRow& report) {
  const Stack stack = load_stack(name);
  const Plan plan = make_plan(stack);
  const DensityGrid& grid = *plan.grids[0];
  const GridReference& tile = *stack.layers[0].grid;
  constexpr int kTimes = 8;
  const int places = effort.repetitions > 3 ? 20000 : 500;
  RandomStream stream(seed, 0, StreamPurpose::test);
  double own = 0, square = 0;
  const double seconds = seconds_of([&] {
    for (int k = 0; k < places; ++k) {
      const double x = tile.size_x * stream.uniform(), y = tile.size_y * stream.uniform();
      const double height = stack.layers[0].thickness * stream.uniform();
      const double u1 = stream.uniform(), u2 = stream.uniform();
      const Direction w = uniform_sphere(u1, u2);
      double sum = 0, sum2 = 0;
      for (int i = 0; i < kTimes; ++i) {
        const double share = std::visit(
            [&]<class M>(const M&) { return ratio_tracked<M>(grid, x, y, height, w, stream); },
            grid.palette()[0]);
        sum += share;
        sum2 += share * share;
      }
      own += (sum2 - sum * sum / kTimes) / (kTimes - 1);
      square += sum2 / kTimes;
    }
  });
  BenchmarkRow row{.what = std::string("grid_") + name + "/shadow ray in double", .kind = "walk"};
  row.seconds = seconds;
  row.ns_per_eval = 1e9 * seconds / (places * kTimes);
  row.baseline = "the mean square of an exact transmittance";
  row.ratio_to_baseline = (square - own) / square;
  report(std::move(row));
}

// A stack with a grid, its walks to be measured.
class GridTrial {
 public:
  GridTrial(const char* name, const BenchmarkEffort& effort, std::uint64_t seed,
            const ReportRow& report)
      : name_(name), effort_(effort), seed_(seed), report_(report), stack_(load_stack(name)) {
    scalar_ = make_plan(stack_);
    lanes_ = scalar_;
    lanes_.isa = effort.isa == Isa::scalar ? isa_from_text("auto") : effort.isa;
    lattices_ = lanes_;
    lattices_.sampling = Sampling::rqmc;
  }

  // Next-event estimation with shadow rays on lanes against the same in double, and against counted
  // walks: time x variance of all orders.
  void measure_shadow_rays() const {
    for (const int count : {1, 16})
      compare("nee" + std::to_string(count) + ", lanes", "shadow rays in double",
              points(lanes_, count, 0), points(scalar_, count, 1));
    compare("nee cells, lanes", "shadow rays in double", cells(lanes_, Estimator::next_event, 0),
            cells(scalar_, Estimator::next_event, 1));
    compare("nee cells, lanes, against counted", "walks counted in cells on lanes",
            cells(lanes_, Estimator::next_event, 0), cells(lanes_, Estimator::analog, 1), 64);
  }

  // Counted walks on lanes against those in double.
  void measure_counted() const {
    compare("counted cells, lanes", "walks in double", cells(lanes_, Estimator::analog, 0),
            cells(scalar_, Estimator::analog, 1));
  }

  // Walks on lattices against random ones.
  void measure_lattices() const {
    for (const int count : {1, 16})
      compare("nee" + std::to_string(count) + ", lattices", "random numbers",
              points(lattices_, count, 0), points(lanes_, count, 1));
    compare("nee cells, lattices", "random numbers", cells(lattices_, Estimator::next_event, 0),
            cells(lanes_, Estimator::next_event, 1));
    compare("counted cells, lattices", "random numbers", cells(lattices_, Estimator::analog, 0),
            cells(lanes_, Estimator::analog, 1));
  }

 private:
  using Walks = std::unique_ptr<Simulation>;

  [[nodiscard]] Walks cells(const Plan& plan, Estimator estimator, int other) const {
    return std::make_unique<Simulation>(stack_, plan, benchmark_incident(), estimator,
                                        CellGrid{16, 32, false}, seed_ + other);
  }
  [[nodiscard]] Walks points(const Plan& plan, int count, int other) const {
    return std::make_unique<Simulation>(stack_, plan, benchmark_incident(), benchmark_points(count),
                                        seed_ + other);
  }
  void compare(const std::string& task, const char* baseline, Walks ours, Walks theirs,
               std::uint64_t their_share = 1) const {
    BenchmarkRow row = time_variance_row(*ours, *theirs, effort_, their_share);
    row.what = std::string("grid_") + name_ + "/" + task;
    row.baseline = baseline;
    row.extra["isa"] = to_text(lanes_.isa);
    report_(std::move(row));
  }

  const char* name_;
  const BenchmarkEffort& effort_;
  std::uint64_t seed_;
  const ReportRow& report_;
  Stack stack_;
  Plan scalar_, lanes_, lattices_;
};

}  // namespace

void measure_grids(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report) {
  tbb::task_arena one(1);
  for (const GridCase& which :
       {GridCase{"sparse", 40, balls()}, GridCase{"dense", 4, everywhere()}})
    one.execute([&] { measure_grid(which, effort, seed, report); });
  for (const char* name : {"woven_cloth", "settled_dust", "blotchy_layer"})
    one.execute([&] {
      measure_ray_variance(name, effort, seed, report);
      const GridTrial trial(name, effort, seed, report);
      trial.measure_shadow_rays();
      trial.measure_counted();
      trial.measure_lattices();
    });
}

}  // namespace lamella
