#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "compare/bench/benchmark.h"
#include "compare/bench/walk_trial.h"
#include "compare/request/stopwatch.h"
#include "phase/math/sampling.h"
#include "phase/stack/builtin_stacks.h"
#include "volume/grains/grain_scene.h"

namespace lamella {
namespace {

struct Ray {
  Direction origin, direction;
};

/// Rays as walks cast them: from the top by the cosine law, and on from where they hit.
std::vector<Ray> rays_among(const GrainScene& scene, const GrainGeometry& g, std::uint64_t seed,
                            int count) {
  RandomStream stream(seed, 0, StreamPurpose::measure);
  std::vector<Ray> rays;
  Ray ray{};
  bool enters = true;
  while (static_cast<int>(rays.size()) < count) {
    if (enters) {
      const double x = g.tile * stream.uniform(), y = g.tile * stream.uniform();
      ray.origin = {x, y, g.top()};
    }
    const double u1 = stream.uniform(), u2 = stream.uniform();
    Direction normal{0, 0, -1};
    if (!enters) {
      const GrainHit hit = scene.trace(rays.back().origin, rays.back().direction);
      enters = hit.end != RayEnd::grain;
      if (enters) continue;
      ray.origin = hit.point;
      normal = hit.normal;
    }
    ray.direction = cosine_hemisphere(normal, u1, u2);
    rays.push_back(ray);
    enters = false;
  }
  return rays;
}

/// The nearest sphere by testing all of them, in the tile alone: what a hierarchy is for.
double nearest_of_all(const std::vector<Direction>& centres, double radius, const Ray& ray) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Direction& c : centres) {
    const Direction m = ray.origin - c;
    const double b = dot(m, ray.direction), outside = dot(m, m) - radius * radius;
    const double disc = b * b - outside;
    if (b < 0 && disc > 0) nearest = std::min(nearest, -b - std::sqrt(disc));
  }
  return nearest;
}

/// f in one direction by walks on lattices against random ones: time x variance.
void measure_lattices(const char* name, const BenchmarkEffort& effort, std::uint64_t seed,
                      const ReportRow& report) {
  const Stack stack = load_stack(name);
  const Plan random = make_plan(stack);
  Plan lattices = random;
  lattices.sampling = Sampling::rqmc;
  Simulation ours(stack, lattices, benchmark_incident(), benchmark_points(1), seed);
  Simulation theirs(stack, random, benchmark_incident(), benchmark_points(1), seed + 1);
  BenchmarkRow row = time_variance_row(ours, theirs, effort);
  row.what = std::string(name) + "/nee1, lattices";
  row.baseline = "random numbers";
  report(std::move(row));
}

}  // namespace

void measure_grain_tracing(const BenchmarkEffort& effort, std::uint64_t seed,
                           const ReportRow& report) {
  if (!GrainScene::is_available()) return;
  tbb::task_arena one(1);
  one.execute([&] { measure_lattices("sphere_bed_dilute", effort, seed, report); });
  const Stack stack = load_stack("sphere_bed_dilute");
  const GrainGeometry g = *stack.grains();
  {
    const auto centres = place_grains(g, seed, 0);
    const GrainScene scene(g, centres);
    const std::vector<Ray> rays = rays_among(scene, g, seed, 4096);
    double sum = 0;
    const auto trace = [&] {
      for (const Ray& ray : rays) sum += scene.trace(ray.origin, ray.direction).point.z;
    };
    const auto shadow = [&] {
      for (const Ray& ray : rays) sum += scene.is_free(ray.origin, ray.direction);
    };
    // All rays against every sphere would take hours: a few are timed, and the time is scaled.
    const std::size_t few = 16;
    const auto all = [&] {
      for (std::size_t k = 0; k < few; ++k) sum += nearest_of_all(centres, g.radius, rays[k]);
    };
    for (const bool nearest : {true, false}) {
      InterleavedTimes times = nearest ? interleave(effort.repetitions, trace, all)
                                       : interleave(effort.repetitions, shadow, all);
      const double rays_traced = static_cast<double>(rays.size() * effort.repetitions);
      BenchmarkRow row{.what = std::string("sphere_bed_dilute/") + (nearest ? "trace" : "shadow"),
                       .kind = "grains"};
      row.seconds = times.total_first();
      row.ns_per_eval = 1e9 * times.total_first() / rays_traced;
      row.baseline = "every sphere of the tile tested, periods and all else left out";
      row.ratio_to_baseline =
          times.median_ratio() * static_cast<double>(rays.size()) / static_cast<double>(few);
      row.extra = {{"rays_per_second", rays_traced / times.total_first()},
                   {"spheres", centres.size()}};
      report(std::move(row));
    }
    [[maybe_unused]] static volatile double sink;
    sink = sum;  // keeps the loops
  }
  // A million spheres: time and memory of the scene.
  GrainGeometry million = g;
  million.tile *= std::sqrt((effort.repetitions > 3 ? 1e6 : 1e5) / g.expected_count());
  std::vector<Direction> centres;
  const double placing = seconds_of([&] { centres = place_grains(million, seed, 0); });
  const std::int64_t before = GrainScene::embree_bytes();
  std::unique_ptr<GrainScene> scene;
  const double building =
      wall_seconds_of([&] { scene = std::make_unique<GrainScene>(million, centres); });
  BenchmarkRow row{.what = "sphere_bed_dilute/build", .kind = "grains"};
  row.seconds = building;
  row.ns_per_eval = 1e9 * building / static_cast<double>(centres.size());
  row.baseline = "placing the spheres";
  row.ratio_to_baseline = placing / building;
  row.extra = {{"spheres", centres.size()},
               {"bytes", GrainScene::embree_bytes() - before +
                             static_cast<std::int64_t>(centres.size() * sizeof(Direction))}};
  report(std::move(row));
}

}  // namespace lamella
