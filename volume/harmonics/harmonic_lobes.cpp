#include "volume/harmonics/harmonic_lobes.h"

#include <algorithm>
#include <cmath>

#include "phase/math/larger_error.h"
#include "volume/harmonics/harmonic_degrees.h"
#include "volume/solver/closed_orders.h"
#include "volume/solver/distinct_channels.h"

namespace lamella {

HarmonicLobes::HarmonicLobes(const Stack& stack, const Plan& plan,
                             std::span<const Direction> incident, CellGrid grid)
    : levels(grid),
      pairs(2 * incident.size(),
            std::vector<std::optional<CellMean>>(static_cast<std::size_t>(grid.cells()))),
      plan_(plan),
      grid_(grid),
      is_first_closed_(lamella::is_first_closed(stack)),
      is_open_below_(stack.is_open_below()) {
  for (const Direction w : incident) {
    incident_.push_back(solvable(w));
    lowest_ = std::min(lowest_, std::abs(incident_.back().z));
  }
  DistinctChannels distinct = distinct_channels(stack);
  channels_ = std::move(distinct.channels);
  channel_of_ = distinct.channel_of;
}

bool HarmonicLobes::sees(std::size_t i, bool up) const {
  return up == (incident_[i].z > 0) || (plan_.transmits && (up || is_open_below_));
}

double HarmonicLobes::row_mean(int channel, std::size_t i, bool up, int row) const {
  const HarmonicCells& cells = levels.last().answers[channel][i].sides[up ? 0 : 1];
  double sum = 0;
  for (const int part : kSummedParts)
    if (!cells.value[part].empty())
      for (int column = 0; column < grid_.columns(); ++column)
        sum += cells.value[part][row * grid_.columns() + column];
  return sum / grid_.columns();
}

double HarmonicLobes::value_of(int c, std::size_t i, bool up, int cell, int part) const {
  const HarmonicCells& cells = levels.last().answers[channel_of_[c]][i].sides[up ? 0 : 1];
  const auto& mirrored = pairs_of(i, up, cell);
  if (cells.value[part].empty()) return 0;
  if (part > 0 || !mirrored) return cells.value[part][cell];
  return cells.value[kWithoutPairs][cell] + mirrored->value[c];
}
double HarmonicLobes::error_of(int c, std::size_t i, bool up, int cell, int part) const {
  const auto& mirrored = pairs_of(i, up, cell);
  if (part > 0 || !mirrored) return levels.error(channel_of_[c], i, up, cell, part);
  return levels.error(channel_of_[c], i, up, cell, kWithoutPairs) + mirrored->error[c];
}

double HarmonicLobes::scale_of(int c, std::size_t i, bool up, int row) const {
  double sum = row_mean(channel_of_[c], i, up, row);
  for (int column = 0; column < grid_.columns(); ++column)
    sum += closed_of(i, up)[row * grid_.columns() + column].value[c] / grid_.columns();
  return sum;
}

const HarmonicEnergies& HarmonicLobes::energies_of(int c, std::size_t i) const {
  return levels.last().answers[channel_of_[c]][i].energies;
}

double HarmonicLobes::worst(int c, std::size_t i, bool up) const {
  double worst = 0;
  for (int row = 0; row < grid_.rows(); ++row) {
    double error = 0;
    for (int column = 0; column < grid_.columns(); ++column) {
      const int cell = row * grid_.columns() + column;
      double sum = closed_of(i, up)[cell].error[c];
      for (const int part : kSummedParts) sum += error_of(c, i, up, cell, part);
      error = larger_error(error, sum);
    }
    const double scale = scale_of(c, i, up, row);
    if (scale > 0) worst = larger_error(worst, error / scale);
  }
  return worst;
}

std::vector<RunResult> HarmonicLobes::results(const DeterministicAccuracy& accuracy,
                                              double tolerance) const {
  std::vector<RunResult> runs(incident_.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    RunResult& run = runs[i];
    run.incident = incident_[i];
    run.estimator = Estimator::deterministic;
    run.grid = grid_;
    run.channels = plan_.channels;
    run.seconds = accuracy.seconds / static_cast<double>(runs.size());
    run.accuracy = accuracy;
    run.accuracy->error = 0;
    for (const bool reflected : {true, false}) {
      const bool up = (incident_[i].z > 0) == reflected;
      SideResult& side = reflected ? run.reflected : run.transmitted;
      if (sees(i, up)) fill_lobes(side, i, up);
      fill_energies(side, i, up);
      if (sees(i, up))
        for (int c = 0; c < plan_.channels; ++c)
          run.accuracy->error = larger_error(run.accuracy->error, worst(c, i, up));
    }
    double defect = 0;
    for (int c = 0; c < plan_.channels; ++c) {
      const HarmonicEnergies& e = energies_of(c, i);
      run.uncollided[c] = {e.uncollided, 0};
      if (e.lost > 0)
        run.lost[c] = {e.lost, levels.bound_of(channel_of_[c], i,
                                               [](const HarmonicEnergies& x) { return x.lost; })};
      run.absorbed[c] = {
          e.absorbed,
          levels.bound_of(channel_of_[c], i, [](const HarmonicEnergies& x) { return x.absorbed; })};
      defect = larger_error(defect, std::abs(e.sum() - 1));
    }
    run.accuracy->energy_defect = defect;
    run.accuracy->reached = run.accuracy->error <= tolerance && defect <= tolerance;
  }
  return runs;
}

void HarmonicLobes::fill_energies(SideResult& side, std::size_t i, bool up) const {
  const bool is_reflected = up == (incident_[i].z > 0);
  for (int c = 0; c < plan_.channels; ++c) {
    const int channel = channel_of_[c];
    const auto of = [&](const auto& energy) {
      return Estimate{energy(levels.last().answers[channel][i].energies),
                      levels.bound_of(channel, i, energy)};
    };
    for (int order = 0; order < 4; ++order)
      side.orders[order][c] =
          of([&](const HarmonicEnergies& e) { return (up ? e.up : e.down)[order]; });
    side.multiple[c] = of([&](const HarmonicEnergies& e) {
      const auto& orders = up ? e.up : e.down;
      double sum = 0;
      for (std::size_t order = 1; order < orders.size(); ++order) sum += orders[order];
      return sum;
    });
    side.total[c] = of([&](const HarmonicEnergies& e) {
      double sum = (up ? e.zero_up : e.zero_down) + (is_reflected ? e.mirrored : 0);
      for (const double x : up ? e.up : e.down) sum += x;
      return sum;
    });
    side.zero[c] = of([&](const HarmonicEnergies& e) {
      return (up ? e.zero_up : e.zero_down) + (is_reflected ? e.mirrored : 0);
    });
    if (is_reflected) side.specular[c] = {energies_of(c, i).specular, 0};
  }
}

void HarmonicLobes::fill_lobes(SideResult& side, std::size_t i, bool up) const {
  const int cells = grid_.cells();
  for (int lobe = 0; lobe < kLobeOrders; ++lobe) {
    if (is_first_closed_ && (lobe == place(Order::zero) || lobe == place(Order::scattered)))
      continue;
    side.lobes[lobe].value.assign(static_cast<std::size_t>(plan_.channels) * cells, 0);
    side.lobes[lobe].standard_error = side.lobes[lobe].value;
  }
  for (int c = 0; c < plan_.channels; ++c)
    for (int cell = 0; cell < cells; ++cell) {
      const std::size_t at = static_cast<std::size_t>(c) * cells + cell;
      const auto put = [&](Order order, Estimate e) {
        side.lobes[order].value[at] = e.value;
        side.lobes[order].standard_error[at] = e.standard_error;
      };
      const auto part = [&](int which) {
        return Estimate{value_of(c, i, up, cell, which), error_of(c, i, up, cell, which)};
      };
      const auto sum = [](Estimate a, Estimate b) {
        return Estimate{a.value + b.value, a.standard_error + b.standard_error};
      };
      const CellMean& mean = closed_of(i, up)[cell];
      const Estimate known{mean.value[c], mean.error[c]};
      // What is closed is order 1, or of order 0 where a boundary is rough.
      const Estimate first = is_first_closed_ ? known : part(kFirstPart);
      Estimate multiple;
      for (int order = 0; order < kHarmonicOrders; ++order) {
        put(static_cast<Order>(order + 1), part(order));
        multiple = sum(multiple, part(order));
      }
      put(Order::one, first);
      put(Order::multiple, multiple);
      Estimate all = sum(first, multiple);
      if (!is_first_closed_) {
        const Estimate zero = sum(known, part(kZeroPart));
        put(Order::scattered, all);
        put(Order::zero, zero);
        all = sum(all, zero);
      }
      put(Order::all, all);
    }
}

}  // namespace lamella
