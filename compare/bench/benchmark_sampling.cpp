#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <array>
#include <cmath>
#include <vector>

#include "compare/bench/benchmark.h"
#include "compare/request/stopwatch.h"
#include "phase/stack/builtin_stacks.h"

namespace lamella {
namespace {

struct SampledLobe {
  const char* name;
  Order order;
};
constexpr SampledLobe kSampledLobes[] = {
    {"order1", Order::one},           {"order2", Order::two},         {"order3", Order::three},
    {"order4plus", Order::four_plus}, {"orders 2+", Order::multiple}, {"all", Order::all}};
constexpr std::size_t kSampledCount = std::size(kSampledLobes);

// Variances of a lobe's cells together, and of its energy, both sides.
struct SampledVariance {
  double cells = 0, energy = 0;
};
using SampledVariances = std::array<SampledVariance, kSampledCount>;

SampledVariances sampled_variances(const Simulation& simulation) {
  const RunResult run = reduce(simulation);
  SampledVariances found{};
  for (std::size_t k = 0; k < kSampledCount; ++k)
    for (const SideResult* side : {&run.reflected, &run.transmitted}) {
      const Order order = kSampledLobes[k].order;
      for (const double se : side->lobes[order].standard_error) found[k].cells += se * se;
      const Estimate energy = order == Order::all        ? side->total[0]
                              : order == Order::multiple ? side->multiple[0]
                                                         : side->orders[place(order)][0];
      found[k].energy += energy.standard_error * energy.standard_error;
    }
  return found;
}

// Directions of f at points: one is near grazing, where little of a walk's depth is seen.
std::vector<Direction> sampled_points() {
  std::vector<Direction> points;
  for (const double mu : {0.9, 0.6, 0.3, 0.1})
    for (const double phi : {0.3, 2.2}) points.push_back(direction_from_mu_phi(mu, phi));
  return points;
}

// The geometric mean of the variances of f at the points, as `cells`.
SampledVariances point_variances(const Simulation& simulation, std::size_t points) {
  SampledVariances found{};
  for (std::size_t k = 0; k < kSampledCount; ++k) {
    const Order order = kSampledLobes[k].order;
    const int slots = simulation.plan().order_slots();
    const bool sums = order == Order::all || order == Order::multiple;
    const int first = order == Order::all        ? place(Order::one)
                      : order == Order::multiple ? place(Order::two)
                                                 : place(order);
    double logarithms = 0;
    for (std::size_t j = 0; j < points; ++j) {
      const Estimate f = batch_estimate(simulation.batches(), [&](const BatchTally& b) {
        double sum = 0;
        for (int slot = first; slot < (sums ? slots : first + 1); ++slot)
          sum += b.f[static_cast<std::size_t>(slot) * simulation.plan().channels * points + j];
        return sum;
      });
      logarithms += 2 * std::log(f.standard_error);
    }
    found[k].cells = std::exp(logarithms / static_cast<double>(points));
  }
  return found;
}

// What is measured: counted walks and next-event estimation on cells, and f at points.
enum class Sampled : std::uint8_t { counted_cells, next_event_cells, points };

SampledVariances measure_one(const Stack& stack, const Plan& plan, Sampled what,
                             std::uint64_t walks, std::uint64_t seed, double& seconds) {
  if (what == Sampled::points) {
    const std::vector<Direction> points = sampled_points();
    Simulation simulation(stack, plan, benchmark_incident(), points, seed);
    seconds = seconds_of([&] { simulation.advance(walks); });
    return point_variances(simulation, points.size());
  }
  const Estimator estimator =
      what == Sampled::counted_cells ? Estimator::analog : Estimator::next_event;
  Simulation simulation(stack, plan, benchmark_incident(), estimator, CellGrid{}, seed);
  seconds = seconds_of([&] { simulation.advance(walks); });
  return sampled_variances(simulation);
}

// Random and rqmc walks of the same number.
struct SamplingPair {
  double walks;
  double seconds[2] = {};
  SampledVariances variances[2] = {};
};

// The slope of -log(variance) over log(walks), by least squares.
template <class VarianceOf>
double variance_slope(const std::vector<SamplingPair>& pairs, const VarianceOf& variance_of) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const SamplingPair& pair : pairs) {
    const double x = std::log(pair.walks), y = -std::log(variance_of(pair));
    if (!std::isfinite(y)) continue;
    n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

std::vector<SamplingPair> measure_pairs(const Stack& stack, Sampled what,
                                        const BenchmarkEffort& effort, std::uint64_t seed) {
  constexpr int kSeeds = 4;
  std::vector<SamplingPair> pairs;
  double last = 0;
  for (std::uint64_t walks = 10000; walks <= 100000000; walks *= 10) {
    // Ten times the walks take ten times as long.
    if (!pairs.empty() && (walks > 1000000 || effort.accuracy_seconds < 1) &&
        10 * last > 10 * effort.accuracy_seconds)
      break;
    SamplingPair pair{.walks = static_cast<double>(walks)};
    for (std::uint64_t k = 0; k < kSeeds; ++k)
      for (const Sampling sampling : {Sampling::random, Sampling::rqmc}) {
        const int place = sampling == Sampling::rqmc ? 1 : 0;
        Plan plan = make_plan(stack);
        plan.isa = effort.isa;
        plan.sampling = sampling;
        double seconds = 0;
        const SampledVariances found = measure_one(stack, plan, what, walks, seed + k, seconds);
        pair.seconds[place] = k == 0 ? seconds : std::min(pair.seconds[place], seconds);
        for (std::size_t lobe = 0; lobe < kSampledCount; ++lobe) {
          pair.variances[place][lobe].cells += found[lobe].cells / kSeeds;
          pair.variances[place][lobe].energy += found[lobe].energy / kSeeds;
        }
      }
    last = kSeeds * (pair.seconds[0] + pair.seconds[1]);
    pairs.push_back(pair);
  }
  return pairs;
}

void report_sampling(const std::string& what, const std::vector<SamplingPair>& pairs,
                     std::size_t lobe, double SampledVariance::*part, const ReportRow& report) {
  const auto variance = [&](const SamplingPair& pair, int sampling) {
    return pair.variances[sampling][lobe].*part;
  };
  BenchmarkRow row{.what = fmt::format("sampling/{}/{}", what, kSampledLobes[lobe].name),
                   .kind = "walk"};
  row.baseline = "random walks, time x variance";
  std::vector<double> walks, ratios, speeds;
  for (const SamplingPair& pair : pairs) {
    if (!(variance(pair, 1) > 0)) continue;
    walks.push_back(pair.walks);
    ratios.push_back(variance(pair, 0) / variance(pair, 1));
    speeds.push_back(pair.seconds[0] / pair.seconds[1]);
    if (pair.walks > 1e6) continue;
    row.seconds = pair.seconds[1];
    row.ratio_to_baseline = ratios.back() * speeds.back();
  }
  if (walks.empty()) return;
  row.extra = {
      {"walks_of", walks},
      {"variance_ratios", ratios},
      {"speed_ratios", speeds},
      {"slope", variance_slope(pairs, [&](const SamplingPair& p) { return variance(p, 1); })},
      {"baseline_slope",
       variance_slope(pairs, [&](const SamplingPair& p) { return variance(p, 0); })}};
  report(std::move(row));
}

}  // namespace

void measure_sampling(const BenchmarkEffort& effort, std::uint64_t seed, const ReportRow& report) {
  tbb::task_arena one(1);
  for (const char* name : {"lambert_sphere_halfspace", "sggx_slab", "vmf_halfspace", "vmf_sand",
                           "spongecake_two_layer"}) {
    const Stack stack = load_stack(name);
    for (const Sampled sampled :
         {Sampled::next_event_cells, Sampled::points, Sampled::counted_cells}) {
      const auto pairs = one.execute([&] { return measure_pairs(stack, sampled, effort, seed); });
      const std::string what =
          fmt::format("{}/{}", name,
                      sampled == Sampled::points
                          ? "points"
                          : to_text(sampled == Sampled::counted_cells ? Estimator::analog
                                                                      : Estimator::next_event) +
                                "/cells");
      for (std::size_t lobe = 0; lobe < kSampledCount; ++lobe)
        report_sampling(what, pairs, lobe, &SampledVariance::cells, report);
      if (sampled == Sampled::points) continue;
      const std::string energies =
          std::string(name) +
          (sampled == Sampled::counted_cells ? "/energy" : "/next-event/energy");
      for (std::size_t lobe = 0; lobe < kSampledCount; ++lobe)
        report_sampling(energies, pairs, lobe, &SampledVariance::energy, report);
    }
  }
}

}  // namespace lamella
