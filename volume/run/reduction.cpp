#include <algorithm>
#include <cmath>

#include "phase/math/larger_error.h"
#include "volume/run/first_check.h"
#include "volume/run/simulation.h"

namespace lamella {
namespace {

constexpr int kOne = place(Order::one);

// Order 1 of one side from its closed form: nothing where walks give it, or where there are no
// cells, as in the depth of a half space.
struct KnownFirst {
  const LobeEstimate* cells = nullptr;
  std::array<Estimate, 3> energy{};  // errors are bounds
};

KnownFirst known_first(const Simulation& simulation, bool up) {
  KnownFirst first;
  if (simulation.order_one() == OrderOne::walked) return first;
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

struct SideTotal {
  Estimate energy;
  bool has_exact_first = false;
};

// What leaves on one side after interfaces alone and after order `from` + 1 and more events.
Estimate energy_from(const Simulation& simulation, bool up, int from, int c) {
  return batch_estimate(simulation.batches(), [&](const BatchTally& b) {
    double sum = zero_of(b, up, c);
    for (int o = from; o < kTallyOrders; ++o) sum += energies_of(b, up)[o][c];
    return sum;
  });
}

// The energy of all orders, with order 1 exact or as walks counted it, whichever has less noise: a
// walk leaves after one order, so what counts in order 1 is missing in the others, and where little
// is absorbed the sum of all is known better than its parts.
SideTotal side_total(const Simulation& simulation, bool up, const KnownFirst& first, int c) {
  const Estimate counted = energy_from(simulation, up, kOne, c);
  if (!first.cells) return {counted};
  const Estimate exact = sum_of(first.energy[c], energy_from(simulation, up, kOne + 1, c));
  if (exact.standard_error < counted.standard_error) return {exact, true};
  return {counted};
}

void reduce_energies(const Simulation& simulation, bool up, const KnownFirst& first,
                     SideResult& side) {
  const auto& batches = simulation.batches();
  for (int c = 0; c < simulation.plan().channels; ++c) {
    for (int o = 0; o < kTallyOrders; ++o)
      side.orders[o][c] =
          batch_estimate(batches, [&](const BatchTally& b) { return energies_of(b, up)[o][c]; });
    if (first.cells) side.orders[kOne][c] = first.energy[c];
    side.total[c] = side_total(simulation, up, first, c).energy;
    side.multiple[c] = batch_estimate(batches, [&](const BatchTally& b) {
      double sum = 0;
      for (int o = place(Order::two); o < kTallyOrders; ++o) sum += energies_of(b, up)[o][c];
      return sum;
    });
    side.zero[c] = batch_estimate(batches, [&](const BatchTally& b) { return zero_of(b, up, c); });
    side.specular[c] = batch_estimate(batches, [&](const BatchTally& b) {
      return (up ? b.energy.specular_up : b.energy.specular_down)[c];
    });
  }
}

SideResult reduce_side(const Simulation& simulation, bool up) {
  const CellTargets& targets = simulation.targets();
  const int channels = simulation.plan().channels;
  const int cells = targets.grid.cells(), count = targets.count();
  const auto& batches = simulation.batches();
  const KnownFirst first = known_first(simulation, up);
  SideResult side;
  reduce_energies(simulation, up, first, side);
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

// Closed forms in the place of what walks found of light that met nothing, and the difference that
// they and order 1 make to the ledger.
void replace(const Simulation& simulation, RunResult& run) {
  const std::array<KnownFirst, 2> sides{known_first(simulation, false),
                                        known_first(simulation, true)};
  const std::optional<double>& uncollided = simulation.closed_first().uncollided;
  for (int c = 0; c < run.channels; ++c) {
    std::array<bool, 2> replaced{};
    for (const bool up : {false, true})
      replaced[up ? 1 : 0] = side_total(simulation, up, sides[up ? 1 : 0], c).has_exact_first;
    run.replaced[c] = batch_estimate(simulation.batches(), [&](const BatchTally& b) {
      double sum = uncollided ? b.energy.uncollided[c] : 0;
      for (const bool up : {false, true})
        if (replaced[up ? 1 : 0]) sum += energies_of(b, up)[kOne][c];
      return sum;
    });
    for (const std::size_t k : {0, 1})
      if (replaced[k]) run.replaced[c].value -= sides[k].energy[c].value;
    if (!uncollided) continue;
    run.replaced[c].value -= *uncollided;
    run.uncollided[c] = {*uncollided, 0};
  }
  run.order_one_p_value = first_check(simulation);
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
  run.holes = simulation.holes();
  const bool up = run.incident.z > 0;
  run.reflected = reduce_side(simulation, up);
  run.transmitted = reduce_side(simulation, !up);
  const auto& batches = simulation.batches();
  for (int c = 0; c < run.channels; ++c) {
    run.uncollided[c] =
        batch_estimate(batches, [&](const BatchTally& b) { return b.energy.uncollided[c]; });
    run.absorbed[c] =
        batch_estimate(batches, [&](const BatchTally& b) { return b.energy.absorbed[c]; });
    run.lost[c] = batch_estimate(batches, [&](const BatchTally& b) { return b.energy.lost[c]; });
    run.thinned[c] =
        batch_estimate(batches, [&](const BatchTally& b) { return b.energy.thinned[c]; });
    run.unresolved[c] =
        batch_estimate(batches, [&](const BatchTally& b) { return b.energy.unresolved[c]; });
  }
  if (run.order_one == OrderOne::exact) replace(simulation, run);
  return run;
}

double largest_relative_error(const Simulation& simulation) {
  double largest = 0;
  const auto consider = [&](const Estimate& e) {
    if (!(e.value <= 1e-3)) largest = larger_error(largest, e.standard_error / e.value);
  };
  for (const bool up : {true, false}) {
    const KnownFirst first = known_first(simulation, up);
    for (int c = 0; c < simulation.plan().channels; ++c) {
      for (int o = first.cells ? kOne + 1 : kOne; o < kTallyOrders; ++o)
        consider(batch_estimate(simulation.batches(),
                                [&](const BatchTally& b) { return energies_of(b, up)[o][c]; }));
      consider(side_total(simulation, up, first, c).energy);
    }
  }
  return largest;
}

}  // namespace lamella
