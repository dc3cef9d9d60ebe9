#include "compare/ensemble/spongecake_accuracy.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "compare/ensemble/lobe_dataset.h"
#include "compare/ensemble/stack_ensemble.h"
#include "compare/fit/least_squares.h"
#include "compare/fit/two_lobe_fit.h"
#include "phase/stack/single_scattering.h"

namespace lamella {
namespace {

// Points per axis of a cell for order 1, which may be narrow.
constexpr int kSinglePoints = 6;
constexpr std::uint64_t kStacksAtOnce = 16;

Direction point_of(Direction wi, const CellGrid& grid, int row, int column, double u, double v,
                   bool up) {
  const double mu2 = 1 - (row + u) / grid.mu_cells;
  const double phi = azimuth(wi) + 2 * kPi * (column + v) / grid.phi_cells;
  return direction_from_mu_phi((up ? 1 : -1) * std::sqrt(mu2), phi);
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double squares(Rgb c) { return c.r * c.r + c.g * c.g + c.b * c.b; }
double sum(Rgb c) { return c.r + c.g + c.b; }

// Far from the seeds of the directions that fits are judged on.
constexpr std::uint64_t kOtherDirections = std::uint64_t{1} << 48;

// The stack's truth along directions that it is not judged on.
MultipleLobes elsewhere(const LobeDatasetPlan& plan, std::uint64_t number, const Stack& stack) {
  const std::uint64_t seed = plan.seed + kOtherDirections;
  return multiple_lobes(
      stack, random_directions(plan.directions, plan.layers, seed, number), plan.grid, plan.walks,
      seed + (((number + 1) * 16 + static_cast<std::uint64_t>(plan.layers)) << 8));
}

SpongecakeAccuracy measured(const LobeDatasetPlan& plan, std::uint64_t number) {
  const LobeDatum datum = lobe_datum(plan, number);
  const SpongecakeTrial trial(datum.stack, datum.lobes);
  SpongecakeAccuracy row{.stack = datum.stack,
                         .noise = datum.lobes.relative_noise(),
                         .multiple_share = trial.multiple_share(),
                         .nothing = trial.errors_of(std::nullopt),
                         .network = trial.errors_of(predicted_lobes(datum.stack))};
  if (!has_least_squares()) return row;
  row.fit = trial.errors_of(trial.best());
  row.fit_elsewhere =
      trial.errors_of(SpongecakeTrial(datum.stack, elsewhere(plan, number, datum.stack)).best());
  return row;
}

}  // namespace

SpongecakeTrial::SpongecakeTrial(const Stack& stack, const MultipleLobes& truth)
    : stack_(stack), incident_(truth.incident), grid_(truth.grid) {
  const std::size_t cells = grid_.cells();
  for (std::size_t d = 0; d < incident_.size(); ++d)
    for (const bool reflected : {true, false})
      for (std::size_t k = 0; k < cells; ++k) {
        direction_.push_back(d);
        reflected_.push_back(reflected);
        row_.push_back(static_cast<int>(k) / grid_.columns());
        column_.push_back(static_cast<int>(k) % grid_.columns());
        Rgb f, variance;
        for (int c = 0; c < 3; ++c) {
          const std::size_t at = 3 * truth_.size() + static_cast<std::size_t>(c);
          f[c] = static_cast<double>(truth.value[at]);
          variance[c] = static_cast<double>(truth.variance[at]);
        }
        truth_.push_back(f);
        variance_.push_back(variance);
        Rgb single;
        for (int p = 0; p < kSinglePoints * kSinglePoints; ++p) {
          const Direction wo = point_of(incident_[d], grid_, row_.back(), column_.back(),
                                        (p / kSinglePoints + 0.5) / kSinglePoints,
                                        (p % kSinglePoints + 0.5) / kSinglePoints,
                                        (incident_[d].z > 0) == reflected);
          single += single_scattering(stack_, incident_[d], wo).layers;
        }
        single_.push_back(1.0 / (kSinglePoints * kSinglePoints) * single);
      }
}

SpongecakeLobes SpongecakeTrial::best(const StopFlag* stop) const {
  std::vector<LobeCell> cells;
  for (std::size_t k = 0; k < truth_.size(); ++k) {
    const Direction wi = incident_[direction_[k]];
    cells.push_back({.wi = wi,
                     .wo = cell_nodes(wi, row_[k], column_[k], grid_.mu_cells, grid_.phi_cells,
                                      (wi.z > 0) == reflected_[k], cell_parts(stack_)),
                     .truth = truth_[k],
                     .variance = variance_[k],
                     .reflected = reflected_[k]});
  }
  return fit_two_lobes(stack_, cells, stack_.is_grey() ? 1 : 3, stop).lobes;
}

std::vector<Rgb> SpongecakeTrial::values(const SpongecakeLobes& lobes) const {
  const Stack second = spongecake_second_stack(stack_, lobes.factors);
  std::vector<Rgb> values;
  for (std::size_t k = 0; k < truth_.size(); ++k) {
    const Direction wi = incident_[direction_[k]];
    const LobeCell cell{.wi = wi,
                        .wo = cell_nodes(wi, row_[k], column_[k], grid_.mu_cells, grid_.phi_cells,
                                         (wi.z > 0) == reflected_[k], cell_parts(stack_)),
                        .reflected = reflected_[k]};
    values.push_back(value_of(second, lobes, cell));
  }
  return values;
}

std::vector<Rgb> SpongecakeTrial::truth() const { return truth_; }

LobeErrors SpongecakeTrial::errors_of(const std::optional<SpongecakeLobes>& lobes) const {
  const std::vector<Rgb> model = lobes ? values(*lobes) : std::vector<Rgb>(truth_.size());
  double difference = 0, noise = 0, multiple = 0, all = 0;
  for (std::size_t k = 0; k < truth_.size(); ++k) {
    difference += squares(model[k] - truth_[k]);
    noise += sum(variance_[k]);
    multiple += squares(truth_[k]);
    all += squares(truth_[k] + single_[k]);
  }
  const double left = std::max(difference - noise, 0.0);
  const auto over = [&](double truth) {
    return truth > noise ? std::sqrt(left / (truth - noise)) : 0;
  };
  return {over(multiple), over(all)};
}

double SpongecakeTrial::multiple_share() const {
  double multiple = 0, single = 0;
  for (std::size_t k = 0; k < truth_.size(); ++k) {
    multiple += sum(truth_[k]);
    single += sum(single_[k]);
  }
  return multiple + single > 0 ? multiple / (multiple + single) : 0;
}

void measure_spongecake_accuracy(const AccuracyEnsemble& ensemble, const RunMonitor& monitor,
                                 const std::function<void(const SpongecakeAccuracy&)>& take) {
  const auto start = std::chrono::steady_clock::now();
  for (const int layers : {1, 2}) {
    const std::uint64_t count = layers == 1 ? ensemble.one_layer : ensemble.two_layers;
    const LobeDatasetPlan plan{.layers = layers,
                               .stacks = count,
                               .walks = ensemble.walks,
                               .seed = ensemble.seed,
                               .directions = ensemble.directions};
    for (std::uint64_t first = 0; first < count && !monitor.is_stopped(); first += kStacksAtOnce) {
      if (monitor.progress)
        monitor.progress(layers == 1 ? "stacks of one layer" : "stacks of two layers",
                         {first, count, seconds_since(start)});
      std::vector<SpongecakeAccuracy> rows(std::min(kStacksAtOnce, count - first));
      tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t k) {
        if (!monitor.is_stopped()) rows[k] = measured(plan, first + k);
      });
      if (monitor.is_stopped()) return;
      for (const SpongecakeAccuracy& row : rows) take(row);
    }
  }
}

}  // namespace lamella
