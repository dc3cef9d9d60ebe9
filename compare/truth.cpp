#include "compare/truth.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <tuple>

namespace lamella {

std::vector<TruthValue> truth_at(const Stack& stack, const std::vector<DirectionPair>& pairs,
                                 std::uint64_t walks, std::uint64_t max_order, std::uint64_t seed,
                                 const std::atomic<bool>* interrupted) {
  struct Point {
    std::size_t pair;
    Direction wo;
    double factor;  // of reversing the pair
  };
  const auto key = [](Direction w) { return std::tuple(w.x, w.y, w.z); };
  std::map<std::tuple<double, double, double>, std::vector<Point>> by_incident;
  std::vector<TruthValue> values(pairs.size());
  const bool reciprocal = stack.is_reciprocal();
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (pairs[k].wi.z == 0 && pairs[k].wo.z == 0)
      throw std::invalid_argument("both cosines are 0; allowed: at most one");
    Direction wi = with_grazing_limit(pairs[k].wi), wo = with_grazing_limit(pairs[k].wo);
    if (wi.z < 0 && !stack.is_open_below())
      throw std::invalid_argument(stack.substrate
                                      ? "light from below meets an opaque substrate"
                                      : "light from below cannot come through a half space");
    if (wo.z < 0 && !stack.is_open_below()) continue;  // nothing gets there
    double factor = 1;
    if (reciprocal && std::abs(wo.z) < std::abs(wi.z)) {
      // f_T(from above) = f_T(from below, reversed) exp(-S)
      if ((wi.z > 0) != (wo.z > 0))
        factor = std::exp(wi.z > 0 ? -stack.one_sidedness() : stack.one_sidedness());
      std::swap(wi, wo);
    }
    by_incident[key(wi)].push_back({k, wo, factor});
  }
  const Plan plan = make_plan(stack, max_order);
  for (auto& [incident, points] : by_incident) {
    std::stable_partition(points.begin(), points.end(), [](const Point& p) { return p.wo.z > 0; });
    std::vector<Direction> directions;
    for (const Point& p : points) directions.push_back(p.wo);
    const auto [x, y, z] = incident;
    Simulation simulation(stack, plan, {x, y, z}, directions, seed);
    run(simulation, {.walks = walks, .target_error = {}, .seconds = {}}, {}, interrupted);
    const std::size_t count = points.size();
    for (std::size_t j = 0; j < count; ++j)
      for (int c = 0; c < 3; ++c) {
        const int channel = std::min(c, plan.channels - 1);
        const Estimate e = batch_estimate(simulation.batches(), [&](const BatchTally& b) {
          double sum = 0;
          for (int o = 0; o < kTallyOrders; ++o)
            sum += b.f[(static_cast<std::size_t>(o) * plan.channels + channel) * count + j];
          return sum;
        });
        values[points[j].pair].f[c] = points[j].factor * e.value;
        values[points[j].pair].standard_error[c] = points[j].factor * e.standard_error;
      }
  }
  return values;
}

}  // namespace lamella
