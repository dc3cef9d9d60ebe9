#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include "phase/math/larger_error.h"
#include "volume/run/first_check.h"
#include "volume/run/simulation.h"

namespace lamella {
namespace {

constexpr int kOne = place(Order::one);
constexpr double kLeastNoise = 1e-8;  // of the known accounts, as a share of the light
// Walks that an account has met, below which their scatter does not tell its error.
constexpr double kFewWalks = 10;

// Order 1 of one side from its closed form: nothing where walks give it, or where there are no
// cells, as in the depth of a half space.
struct KnownFirst {
  const LobeEstimate* cells = nullptr;
  std::array<Estimate, 3> energy{};  // errors are bounds
};

KnownFirst known_first(const Simulation& simulation, OrderOne order_one, bool up) {
  KnownFirst first;
  if (order_one == OrderOne::walked) return first;
  const LobeEstimate& cells = up ? simulation.closed_first().up : simulation.closed_first().down;
  if (cells.value.empty()) return first;
  first.cells = &cells;
  const CellGrid& grid = simulation.targets().grid;
  for (std::size_t k = 0; k < cells.value.size(); ++k) {
    Estimate& energy = first.energy[k / static_cast<std::size_t>(grid.cells())];
    energy.value += grid.projected_solid_angle() * cells.value[k];
    energy.standard_error += grid.projected_solid_angle() * cells.standard_error[k];
  }
  return first;
}

Estimate sum_of(const Estimate& a, const Estimate& b) {
  return {a.value + b.value, a.standard_error + b.standard_error};
}

const auto& energies_of(const BatchTally& b, bool up) { return up ? b.energy.up : b.energy.down; }

double zero_of(const BatchTally& b, bool up, int c) {
  return (up ? b.energy.zero_up : b.energy.zero_down)[c];
}

// The books of one channel. A walk ends in one account, so what walks counted too much in those
// whose energy is known is missing in the others: every other account is corrected by its
// regression on that excess. The corrected accounts sum to what is left by the known ones, as the
// walks' own books are balanced, and an account without noise of its own stays as it is.
class Books {
 public:
  Books(const Simulation& simulation, OrderOne order_one, int c) : batches_(simulation.batches()) {
    if (order_one == OrderOne::walked) return;
    for (const bool up : {false, true}) sides_.push_back(known_first(simulation, order_one, up));
    const std::optional<double>& uncollided = simulation.closed_first().uncollided;
    counted_.assign(batches_.size(), 0);
    double known = 0;
    for (const bool up : {false, true})
      if (sides_[up].cells) {
        known += sides_[up].energy[c].value;
        bound_ += sides_[up].energy[c].standard_error;
        for (std::size_t b = 0; b < batches_.size(); ++b)
          counted_[b] += energies_of(batches_[b], up)[kOne][c];
      }
    if (uncollided) {
      known += *uncollided;
      for (std::size_t b = 0; b < batches_.size(); ++b)
        counted_[b] += batches_[b].energy.uncollided[c];
    }
    walks_ = sum_over([](const BatchTally& b) { return static_cast<double>(b.walks); });
    if (walks_ == 0) return;
    mean_ = std::accumulate(counted_.begin(), counted_.end(), 0.0) / walks_;
    excess_ = mean_ - known;
    for (std::size_t b = 0; b < batches_.size(); ++b) spread_ += deviation(b) * deviation(b);
    is_known_ = spread_ > kLeastNoise * kLeastNoise * walks_ * walks_;
    for (const Layer& layer : simulation.stack().layers)
      albedo_ = std::max(albedo_, layer.albedo[c]);
    if (const auto& below = simulation.stack().substrate)
      albedo_ = below->model.empty() ? std::max(albedo_, below->albedo[c]) : 1;
    // Of a forced first collision: where higher orders are rare walks have one event each.
    if (uncollided && simulation.collisions() > 0)
      chance_ = std::clamp(
          (1 - *uncollided) * walks_ / static_cast<double>(simulation.collisions()), 0.0, 1.0);
  }
  /// Whether the known accounts have their closed forms: not where the walks' own have no noise to
  /// speak of, which float's rounding would be taken for.
  [[nodiscard]] bool is_known() const { return is_known_; }

  // Of an account that walks counted, and of a known one beside it, which `exact` has.
  template <class SumOf>
  [[nodiscard]] Estimate estimate(const SumOf& sum_of, const Estimate& exact = {}) const {
    if (!is_known_) return batch_estimate(batches_, sum_of);
    // Batches may differ by a walk: what stands for a mean share of their walks varies with
    // nothing.
    const double share = sum_over(sum_of) / walks_;
    double together = 0;
    for (std::size_t b = 0; b < batches_.size(); ++b)
      together +=
          deviation(b) * (sum_of(batches_[b]) - share * static_cast<double>(batches_[b].walks));
    const double slope = together / spread_;
    Estimate corrected = batch_estimate(batches_, [&](const BatchTally& batch) {
      return sum_of(batch) - slope * deviation(static_cast<std::size_t>(&batch - batches_.data()));
    });
    corrected.value += exact.value - slope * excess_;
    // What a closed form is wrong by is in its own account and, the other way, in the excess.
    corrected.standard_error += std::abs(1 + slope) * exact.standard_error +
                                std::abs(slope) * (bound_ - exact.standard_error);
    return corrected;
  }

  /// The standard error that an account of light after `events` events or more has at least: where
  /// few walks were met, or none, that of one walk more than were. Each weighs its albedos, and the
  /// chance of a forced collision, at most. 0 where walks give order 1, whose light is most.
  [[nodiscard]] double least_error(double value, int events) const {
    const double weight = chance_ * std::pow(albedo_, events);
    if (!is_known_ || !(weight > 0)) return 0;
    const double met = std::max(value, 0.0) * walks_ / weight;
    return met < kFewWalks ? weight * std::sqrt(met + 1) / walks_ : 0;
  }

  [[nodiscard]] const KnownFirst* first(bool up) const {
    return !is_known_ || !sides_[up].cells ? nullptr : &sides_[up];
  }

 private:
  // Of what a batch counted in the known accounts.
  [[nodiscard]] double deviation(std::size_t b) const {
    return counted_[b] - mean_ * static_cast<double>(batches_[b].walks);
  }
  template <class SumOf>
  [[nodiscard]] double sum_over(const SumOf& sum_of) const {
    double sum = 0;
    for (const BatchTally& b : batches_) sum += sum_of(b);
    return sum;
  }

  const std::vector<BatchTally>& batches_;
  std::vector<KnownFirst> sides_;  // below, above
  std::vector<double> counted_;
  double walks_ = 0, mean_ = 0, excess_ = 0, spread_ = 0, bound_ = 0;
  double albedo_ = 0, chance_ = 1;  // the largest; the most that a walk stands for
  bool is_known_ = false;
};

void reduce_energies(const Simulation& simulation, OrderOne order_one, bool up, SideResult& side) {
  for (int c = 0; c < simulation.plan().channels; ++c) {
    const Books books(simulation, order_one, c);
    const KnownFirst* first = books.first(up);
    // Of an account with orders from `events` on and a known one beside them.
    const auto not_below = [&](Estimate e, int events, double known) {
      if (first)
        e.standard_error = std::max(e.standard_error, books.least_error(e.value - known, events));
      return e;
    };
    for (int o = 0; o < kTallyOrders; ++o)
      side.orders[o][c] = first && o == kOne ? first->energy[c]
                                             : not_below(books.estimate([&](const BatchTally& b) {
                                                 return energies_of(b, up)[o][c];
                                               }),
                                                         std::min(o + 1, 3), 0);
    const auto beyond = [&](int order, bool with_zero, const Estimate& exact) {
      return books.estimate(
          [&, order, with_zero](const BatchTally& b) {
            double sum = with_zero ? zero_of(b, up, c) : 0;
            for (int o = order; o < kTallyOrders; ++o) sum += energies_of(b, up)[o][c];
            return sum;
          },
          exact);
    };
    side.multiple[c] = not_below(beyond(place(Order::two), false, {}), 2, 0);
    side.total[c] =
        first ? not_below(beyond(kOne + 1, true, first->energy[c]), 2, first->energy[c].value)
              : beyond(kOne, true, {});
    side.zero[c] = books.estimate([&](const BatchTally& b) { return zero_of(b, up, c); });
    side.specular[c] = books.estimate([&](const BatchTally& b) {
      return (up ? b.energy.specular_up : b.energy.specular_down)[c];
    });
  }
}

SideResult reduce_side(const Simulation& simulation, OrderOne order_one, bool up) {
  const CellTargets& targets = simulation.targets();
  const int channels = simulation.plan().channels;
  const int cells = targets.grid.cells(), count = targets.count();
  const auto& batches = simulation.batches();
  const KnownFirst first = known_first(simulation, order_one, up);
  SideResult side;
  reduce_energies(simulation, order_one, up, side);
  if (!up && !targets.both_sides) return side;
  const int slots = simulation.plan().order_slots();
  for (int o = 0; o < static_cast<int>(side.lobes.size()); ++o) {
    const bool of_interfaces = o == place(Order::zero) || o == place(Order::scattered);
    if (of_interfaces && !simulation.plan().rough_boundaries) continue;
    LobeEstimate& lobe = side.lobes[o];
    if (first.cells && o == kOne) {
      lobe = *first.cells;
      continue;
    }
    lobe.value.resize(static_cast<std::size_t>(channels) * cells);
    lobe.standard_error.resize(lobe.value.size());
    const bool has_first = o == place(Order::all) || o == place(Order::scattered);
    for (int c = 0; c < channels; ++c)
      for (int cell = 0; cell < cells; ++cell) {
        const int target = target_of(targets, up, cell);
        const auto slot = [&](int order) {
          return (static_cast<std::size_t>(order) * channels + c) * count + target;
        };
        Estimate e = batch_estimate(batches, [&](const BatchTally& b) {
          if (o < kTallyOrders) return b.f[slot(o)];
          if (o == place(Order::zero)) return b.f[slot(kZeroSlot)];
          double sum = 0;
          const int begin = o == place(Order::multiple) ? place(Order::two)
                            : first.cells               ? kOne + 1
                                                        : kOne;
          const int end = o == place(Order::all) ? slots : kTallyOrders;
          for (int order = begin; order < end; ++order) sum += b.f[slot(order)];
          return sum;
        });
        const std::size_t k = static_cast<std::size_t>(c) * cells + cell;
        if (first.cells && has_first) {
          const bool empty = e.standard_error == 0;
          e = sum_of(e, {first.cells->value[k], first.cells->standard_error[k]});
          // A cell that no other order was seen in has no standard error.
          if (empty) e.standard_error = 0;
        }
        lobe.value[k] = e.value;
        lobe.standard_error[k] = e.standard_error;
      }
  }
  return side;
}

}  // namespace

RunResult reduce(const Simulation& simulation) {
  RunResult run;
  run.incident = simulation.incident();
  run.estimator = simulation.estimator();
  run.grid = simulation.targets().grid;
  run.channels = simulation.plan().channels;
  run.walks = simulation.walks();
  run.collisions = simulation.collisions();
  run.max_order = simulation.plan().max_order;
  run.thinning = simulation.plan().thinning;
  run.sampling = simulation.sampling();
  run.order_one = simulation.order_one();
  if (run.order_one == OrderOne::exact) {
    // Walks have no closed form to be wrong about: where the two differ, they are kept.
    run.order_one_p_value = first_check(simulation);
    if (run.order_one_p_value < kImplausibleFirst) run.order_one = OrderOne::walked;
  }
  run.holes = simulation.holes();
  const bool up = run.incident.z > 0;
  run.reflected = reduce_side(simulation, run.order_one, up);
  run.transmitted = reduce_side(simulation, run.order_one, !up);
  const bool knows_uncollided =
      run.order_one == OrderOne::exact && simulation.closed_first().uncollided.has_value();
  for (int c = 0; c < run.channels; ++c) {
    const Books books(simulation, run.order_one, c);
    const auto account = [&](const auto& of) {
      return books.estimate([&](const BatchTally& b) { return (b.energy.*of)[c]; });
    };
    run.uncollided[c] = knows_uncollided && books.is_known()
                            ? Estimate{simulation.closed_first().uncollided.value_or(0), 0}
                            : account(&EnergySums::uncollided);
    run.absorbed[c] = account(&EnergySums::absorbed);
    run.lost[c] = account(&EnergySums::lost);
    run.thinned[c] = account(&EnergySums::thinned);
    run.unresolved[c] = account(&EnergySums::unresolved);
  }
  return run;
}

double largest_relative_error(const Simulation& simulation) {
  double largest = 0;
  const auto consider = [&](const Estimate& e) {
    if (!(e.value <= 1e-3)) largest = larger_error(largest, e.standard_error / e.value);
  };
  for (const bool up : {true, false}) {
    SideResult side;
    reduce_energies(simulation, simulation.order_one(), up, side);
    const bool known = known_first(simulation, simulation.order_one(), up).cells;
    for (int c = 0; c < simulation.plan().channels; ++c) {
      for (int o = known ? kOne + 1 : kOne; o < kTallyOrders; ++o) consider(side.orders[o][c]);
      consider(side.total[c]);
    }
  }
  return largest;
}

}  // namespace lamella
