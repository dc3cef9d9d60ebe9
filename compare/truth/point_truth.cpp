#include "compare/truth/point_truth.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <map>
#include <stdexcept>
#include <tuple>

#include "compare/request/run_keeper.h"
#include "volume/result/number_bytes.h"
#include "volume/solver/closed_first.h"
#include "volume/solver/closed_orders.h"
#include "volume/solver/pair_table.h"

namespace lamella {
namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// A pair among those of one incident direction.
struct Point {
  std::size_t pair;
  Direction wo;
  double factor;  // of reversing the pair
};

// What a direction's walks found at its points.
std::vector<TruthValue> values_of(const Simulation& simulation, const std::vector<Point>& points) {
  const Plan& plan = simulation.plan();
  std::array<Estimate, 3> unresolved;
  for (int c = 0; c < plan.channels; ++c)
    unresolved[c] = batch_estimate(simulation.batches(),
                                   [&](const BatchTally& b) { return b.energy.unresolved[c]; });
  const std::size_t count = points.size();
  std::vector<TruthValue> values(count);
  const bool exact = plan.order_one == OrderOne::exact && !why_no_closed_first(simulation.stack());
  const int first = exact ? place(Order::two) : place(Order::one);
  for (std::size_t j = 0; j < count; ++j) {
    TruthValue& value = values[j];
    value.walks = simulation.walks();
    const Rgb one =
        exact ? closed_orders(simulation.stack(), simulation.incident(), points[j].wo).one : Rgb();
    for (int c = 0; c < 3; ++c) {
      const int channel = std::min(c, plan.channels - 1);
      const Estimate e = batch_estimate(simulation.batches(), [&](const BatchTally& b) {
        double sum = 0;
        for (int o = first; o < plan.order_slots(); ++o)
          sum += b.f[(static_cast<std::size_t>(o) * plan.channels + channel) * count + j];
        return sum;
      });
      value.f[c] = points[j].factor * (one[channel] + e.value);
      value.standard_error[c] = points[j].factor * e.standard_error;
      value.unresolved[c] = {points[j].factor * unresolved[channel].value,
                             points[j].factor * unresolved[channel].standard_error};
    }
  }
  return values;
}

// The azimuth of w_o relative to w_i.
double relative_azimuth(Direction wi, Direction wo) {
  return std::atan2(wi.x * wo.y - wi.y * wo.x, wi.x * wo.x + wi.y * wo.y);
}

void refuse_double_grazing(const DirectionPair& pair) {
  if (std::abs(pair.wi.z) < kGrazingLimit && std::abs(pair.wo.z) < kGrazingLimit)
    throw std::invalid_argument("both cosines are 0; allowed: at most one");
}

// Where a table of the solution pays: the pairs of `order` that it has, into `values`. Returns the
// others.
std::vector<std::size_t> without_tabulated(
    const DeterministicSolution& solution, const std::vector<DirectionPair>& pairs,
    const std::function<Rgb(const DirectionPair&)>& closed_part, std::vector<std::size_t> order,
    std::vector<TruthValue>& values) {
  std::vector<CosinePair> cosines;
  cosines.reserve(order.size());
  for (const std::size_t k : order)
    cosines.push_back({with_grazing_limit(pairs[k].wi).z, with_grazing_limit(pairs[k].wo).z});
  const std::optional<PairTable> table = PairTable::make(solution, cosines);
  if (!table) return order;
  std::vector<char> found(order.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, order.size(), 1024), [&](const auto& range) {
    for (std::size_t j = range.begin(); j < range.end(); ++j) {
      const DirectionPair& pair = pairs[order[j]];
      const auto value = table->at(cosines[j], kPi - relative_azimuth(with_grazing_limit(pair.wi),
                                                                      with_grazing_limit(pair.wo)));
      if (!value) continue;
      values[order[j]] = {value->order[Order::all] + closed_part(pair), value->error};
      found[j] = 1;
    }
  });
  std::vector<std::size_t> left;
  for (std::size_t j = 0; j < order.size(); ++j)
    if (!found[j]) left.push_back(order[j]);
  return left;
}

}  // namespace

void check_pair(const Stack& stack, const DirectionPair& pair) {
  refuse_double_grazing(pair);
  if (with_grazing_limit(pair.wi).z < 0 && !stack.is_open_below())
    throw std::invalid_argument(stack.substrate
                                    ? "light from below meets an opaque substrate"
                                    : "light from below cannot come through a half space");
}

std::string to_bytes(const std::vector<TruthValue>& values) {
  NumberWriter out;
  for (const TruthValue& v : values) {
    out.put(v.walks);
    for (int c = 0; c < 3; ++c)
      for (const double x :
           {v.f[c], v.standard_error[c], v.unresolved[c].value, v.unresolved[c].standard_error})
        out.put(x);
  }
  return out.take();
}

std::vector<TruthValue> truth_values_from(std::string_view bytes, std::size_t count) {
  NumberReader in(bytes);
  std::vector<TruthValue> values(count);
  for (TruthValue& v : values) {
    v.walks = in.get<std::uint64_t>();
    for (int c = 0; c < 3; ++c)
      for (double* x :
           {&v.f[c], &v.standard_error[c], &v.unresolved[c].value, &v.unresolved[c].standard_error})
        *x = in.get<double>();
  }
  in.end();
  return values;
}

std::vector<TruthValue> truth_at(const Stack& stack, const Plan& plan,
                                 const std::vector<DirectionPair>& pairs, std::uint64_t walks,
                                 std::uint64_t seed, const RunMonitor& monitor,
                                 std::optional<double> seconds) {
  const auto key = [](Direction w) { return std::tuple(w.x, w.y, w.z); };
  std::map<std::tuple<double, double, double>, std::vector<Point>> by_incident;
  std::vector<TruthValue> values(pairs.size());
  const bool reciprocal = stack.is_reciprocal();
  const double below = stack.index_of(stack.layers.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    check_pair(stack, pairs[k]);
    Direction wi = with_grazing_limit(pairs[k].wi), wo = with_grazing_limit(pairs[k].wo);
    if (wo.z < 0 && !stack.is_open_below()) continue;  // nothing gets there
    double factor = 1;
    if (reciprocal && std::abs(wo.z) < std::abs(wi.z)) {
      // f_T(from above) = f_T(from below, reversed) exp(-S)
      if ((wi.z > 0) != (wo.z > 0))
        factor = std::exp(wi.z > 0 ? -stack.one_sidedness() : stack.one_sidedness());
      // Radiance carries the square of the index.
      const double there = wo.z > 0 ? 1 : below, here = wi.z > 0 ? 1 : below;
      factor *= there * there / (here * here);
      std::swap(wi, wo);
    }
    by_incident[key(wi)].push_back({k, wo, factor});
  }
  const auto start = std::chrono::steady_clock::now();
  std::size_t left = by_incident.size();
  for (auto& [incident, of_incident] : by_incident) {
    std::vector<Point>& points = of_incident;
    const auto [x, y, z] = incident;
    const Direction wi{x, y, z};
    std::stable_partition(points.begin(), points.end(), [](const Point& p) { return p.wo.z > 0; });
    const auto walked = [&] {
      std::vector<Direction> directions;
      for (const Point& p : points) directions.push_back(p.wo);
      Simulation simulation(stack, plan, wi, directions, seed);
      StopRule rule{.walks = walks, .target_error = {}, .seconds = {}};
      if (seconds)
        rule.seconds =
            std::max(*seconds - seconds_since(start), 0.05 * *seconds) / static_cast<double>(left);
      run(simulation, rule, {}, monitor.stop);
      return values_of(simulation, points);
    };
    std::vector<TruthValue> found(points.size());
    if (!monitor.keeper)
      found = walked();
    else if (const auto kept = monitor.keeper->piece([&] { return to_bytes(walked()); }))
      found = truth_values_from(*kept, points.size());
    --left;
    for (std::size_t j = 0; j < points.size(); ++j) values[points[j].pair] = found[j];
  }
  return values;
}

std::vector<TruthValue> truth_at(const DeterministicSolution& solution,
                                 const std::vector<DirectionPair>& pairs,
                                 const SolverReport& report) {
  const auto start = std::chrono::steady_clock::now();
  // A field holds every pair of its cosines: few at a time, sorted so that pairs share them.
  constexpr std::size_t kCosines = 64;
  const Stack& stack = solution.stack();
  std::vector<TruthValue> values(pairs.size());
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    refuse_double_grazing(pairs[k]);
    if (pairs[k].wo.z >= 0 || stack.is_open_below()) order.push_back(k);
  }
  const auto cosines = [&](std::size_t k) {
    return std::pair(with_grazing_limit(pairs[k].wi).z, with_grazing_limit(pairs[k].wo).z);
  };
  const auto closed_part = [&](const DirectionPair& pair) {
    return closed_orders(stack, with_grazing_limit(pair.wi), with_grazing_limit(pair.wo)).all();
  };
  order = without_tabulated(solution, pairs, closed_part, std::move(order), values);
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return cosines(a) < cosines(b); });
  const auto tell = [&](std::size_t done) {
    if (report)
      report({.task = SolverProgress::Task::pairs,
              .nodes = solution.accuracy().nodes,
              .modes = solution.accuracy().modes,
              .error = solution.accuracy().error,
              .share = static_cast<double>(done) / static_cast<double>(order.size()),
              .seconds = seconds_since(start)});
  };
  for (std::size_t from = 0; from < order.size();) {
    tell(from);
    std::map<double, std::size_t> in, out;
    std::size_t to = from;
    for (; to < order.size(); ++to) {
      const auto [mu_i, mu_o] = cosines(order[to]);
      if ((in.size() == kCosines && !in.contains(mu_i)) ||
          (out.size() == kCosines && !out.contains(mu_o)))
        break;
      in.try_emplace(mu_i, in.size());
      out.try_emplace(mu_o, out.size());
    }
    std::vector<double> mu_i(in.size()), mu_o(out.size());
    for (const auto& [mu, place] : in) mu_i[place] = mu;
    for (const auto& [mu, place] : out) mu_o[place] = mu;
    const DeterministicField field = solution.field(mu_i, mu_o);
    for (; from < to; ++from) {
      tell(from);
      const Direction wi = with_grazing_limit(pairs[order[from]].wi);
      const Direction wo = with_grazing_limit(pairs[order[from]].wo);
      const DeterministicValue multiple =
          field.multiple_refined(in.at(wi.z), out.at(wo.z), kPi - relative_azimuth(wi, wo));
      values[order[from]] = {multiple.order[Order::all] + closed_part(pairs[order[from]]),
                             multiple.error};
    }
  }
  return values;
}

std::optional<std::string> why_no_answer(const std::vector<TruthValue>& values) {
  constexpr double kRounding = 1e-12;  // of the brightest pair
  double brightest = 0;
  for (const TruthValue& v : values) brightest = std::max(brightest, v.f.max());
  for (const TruthValue& v : values)
    for (int c = 0; c < 3; ++c) {
      const double f = v.f[c], bound = v.standard_error[c];
      if (!std::isfinite(f) || !std::isfinite(bound)) return "its numbers are not finite";
      if (f < -bound - kRounding * brightest)
        return fmt::format("f is {:.3g} at a pair, below 0 by more than its bound, {:.1e}", f,
                           bound);
    }
  return std::nullopt;
}

}  // namespace lamella
