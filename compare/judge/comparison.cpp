#include "compare/judge/comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "compare/judge/lobe_sums.h"
#include "compare/judge/missing_light.h"
#include "compare/judge/statistics.h"

namespace lamella {
namespace {

// Walks per batch below which differences between patches, where most noise cancels and rare walks
// count, are too skew for Hotelling's test (at 50 it rejects 1 true slab in 10, at 200 none in 40).
constexpr double kWalksPerBatch = 200;

std::vector<double> grouped_values(const std::vector<double>& values, const std::vector<int>& group,
                                   int groups) {
  std::vector<double> out(groups);
  for (std::size_t k = 0; k < values.size(); ++k)
    if (group[k] >= 0) out[group[k]] += values[k];
  return out;
}

// A stochastic model's parts are dealt to the truth's batches, each taking its part's deviation
// from the mean of all: the means stay, their covariance becomes that of the difference.
void add_noise(BatchSums& sums, const std::vector<OrderMap<std::vector<double>>>& parts,
               int order) {
  if (parts.empty()) return;
  const std::size_t cells = parts[0][order].size(), batches = sums.sums.size();
  std::vector<double> mean(cells);
  for (const auto& part : parts)
    for (std::size_t k = 0; k < cells; ++k)
      mean[k] += part[order][k] / static_cast<double>(parts.size());
  const double stretch =
      std::sqrt(static_cast<double>(batches) / static_cast<double>(parts.size()));
  for (std::size_t b = 0; b < batches; ++b)
    for (std::size_t k = 0; k < cells; ++k)
      sums.sums[b][k] -= sums.walks[b] * stretch * (parts[b % parts.size()][order][k] - mean[k]);
}

// Batches that all hold the bounded truth.
BatchSums same_in_batches(const std::vector<double>& values, std::size_t batches) {
  return {std::vector<double>(batches, 1.0), std::vector<std::vector<double>>(batches, values)};
}

// Standard errors of a stochastic model's cells.
std::vector<double> noise_of_parts(const std::vector<OrderMap<std::vector<double>>>& parts,
                                   int order) {
  if (parts.empty()) return {};
  BatchSums sums = same_in_batches(std::vector<double>(parts[0][order].size()), parts.size());
  add_noise(sums, parts, order);
  return means_of(sums).standard_error;
}

// Per group of cells, the sum of the budgets of the channels that it has cells of.
std::vector<double> grouped_budget(const std::vector<double>& budget, const std::vector<int>& group,
                                   int groups) {
  if (budget.empty()) return {};
  const std::size_t cells = group.size() / budget.size();
  std::vector<double> out(groups);
  for (std::size_t c = 0; c < budget.size(); ++c) {
    std::vector<bool> seen(groups);
    for (std::size_t k = c * cells; k < (c + 1) * cells; ++k) {
      if (group[k] < 0 || seen[group[k]]) continue;
      seen[group[k]] = true;
      out[group[k]] += budget[c];
    }
  }
  return out;
}

// The group of a cell when groups of cells are grouped once more.
std::vector<int> group_of_group(const std::vector<int>& first, const std::vector<int>& second) {
  std::vector<int> out;
  for (const int g : first) out.push_back(g < 0 ? -1 : second[g]);
  return out;
}

// `bounds`: error bounds of the truth's cells; empty for walks. `budget`: per channel, how much the
// sum of the cells may be too low; empty where nothing is missing.
double p_value_of(const BatchSums& sums, const std::vector<double>& model,
                  const std::vector<double>& bounds, const std::vector<double>& budget,
                  const CellGrid& grid, int channels) {
  const CellGroups patches = cell_patches(grid, channels);
  const std::vector<int>& patch = patches.group;
  const int patch_count = patches.count;
  const BatchSums patched = grouped(sums, patch, patch_count);
  const std::vector<double> patched_model = grouped_values(model, patch, patch_count);
  // Patches that are seen too rarely are pooled like cells are.
  // `cell_group`: of each cell among the quantities of s.
  const auto tests = [&](const BatchSums& s, const std::vector<double>& expected,
                         const std::vector<double>& known, const std::vector<int>& cell_group,
                         bool hotelling) {
    const auto uncertainty = [](const std::vector<double>& values,
                                const std::vector<double>& within) {
      std::vector<double> out;
      for (std::size_t k = 0; k < values.size(); ++k)
        out.push_back(kProjectionTolerance * std::abs(values[k]) + within[k]);
      return out;
    };
    const std::vector<int> group = pooled_groups(s, kPooledEvents);
    const int groups = group.empty() ? 0 : 1 + *std::max_element(group.begin(), group.end());
    if (groups == 0) {
      // Hardly anything arrives: all that can be told is whether anything should. A walk adds at
      // most 1 to the energy, so the chance that none arrives is at most exp(-expected energy).
      const std::vector<int> one(s.quantities(), 0);
      const Means mean = means_of(grouped(s, one, 1));
      const std::vector<double> total = grouped_values(expected, one, 1);
      const std::vector<double> missing =
          grouped_budget(budget, group_of_group(cell_group, one), 1);
      if (mean.value[0] == 0)
        return std::exp(-std::max(0.0, total[0] - (missing.empty() ? 0 : missing[0])) *
                        grid.projected_solid_angle() *
                        std::accumulate(s.walks.begin(), s.walks.end(), 0.0) / channels);
      return largest_deviation_p_value(
          mean, total, uncertainty(total, grouped_values(known, one, 1)), s.batches(), missing);
    }
    const BatchSums pooled = grouped(s, group, groups);
    const std::vector<double> pooled_expected = grouped_values(expected, group, groups);
    const std::vector<double> known_to =
        uncertainty(pooled_expected, grouped_values(known, group, groups));
    return hotelling ? hotelling_p_value(pooled, pooled_expected, known_to)
                     : largest_deviation_p_value(
                           means_of(pooled), pooled_expected, known_to, s.batches(),
                           grouped_budget(budget, group_of_group(cell_group, group), groups));
  };
  const double fewest = *std::min_element(sums.walks.begin(), sums.walks.end());
  std::vector<int> own(model.size());
  std::iota(own.begin(), own.end(), 0);
  const double broad = tests(patched, patched_model, grouped_values(bounds, patch, patch_count),
                             patch, budget.empty() && fewest >= kWalksPerBatch);
  const double local = tests(sums, model, bounds, own, false);
  if (budget.empty()) return std::min(1.0, 2 * std::min(broad, local));
  // The missing light is bounded in all: the whole lobe shows what no patch does.
  std::vector<int> channel(model.size());
  for (std::size_t k = 0; k < model.size(); ++k)
    channel[k] = static_cast<int>(k / (model.size() / channels));
  const double whole =
      tests(grouped(sums, channel, channels), grouped_values(model, channel, channels),
            grouped_values(bounds, channel, channels), channel, false);
  return std::min(1.0, 3 * std::min({broad, local, whole}));
}

// Order 1 in closed form beside walks of the others.
struct ExactFirst {
  const LobeEstimate& lobe;

  [[nodiscard]] std::vector<double> taken_from(const std::vector<double>& model) const {
    std::vector<double> rest = model;
    for (std::size_t k = 0; k < rest.size(); ++k) rest[k] -= lobe.value[k];
    return rest;
  }
  // What is known of the difference: the closed form's bound, and the projection of this part.
  void add_bounds(std::vector<double>& bounds) const {
    for (std::size_t k = 0; k < bounds.size(); ++k)
      bounds[k] += lobe.standard_error[k] + kProjectionTolerance * std::abs(lobe.value[k]);
  }
};

// Whether each cell of the model is as near to the truth as the truth's bound and what is known of
// the projection allow.
bool is_within_bounds(const LobeComparison& l) {
  double mean = 0;
  for (const double m : l.model) mean += std::abs(m) / static_cast<double>(l.model.size());
  for (std::size_t k = 0; k < l.truth.size(); ++k) {
    const double projection =
        kProjectionTolerance * std::max(std::abs(l.model[k]), kProjectionFloor * mean);
    const double open = l.projection_error.empty() ? 0 : l.projection_error[k];
    if (std::abs(l.model[k] - l.truth[k]) > l.standard_error[k] + projection + open) return false;
  }
  return true;
}

// Mean squared error that a bounded truth could hide.
double hidden_by_bounds(const LobeComparison& l) {
  double hidden = 0;
  for (std::size_t k = 0; k < l.truth.size(); ++k) {
    const double most = std::abs(l.model[k] - l.truth[k]) + l.standard_error[k];
    hidden += most * most / static_cast<double>(l.truth.size());
  }
  return hidden;
}

}  // namespace

std::string to_text(Verdict verdict) {
  switch (verdict) {
    case Verdict::agrees:
      return "agrees";
    case Verdict::differs:
      return "differs";
    case Verdict::insufficient:
      break;
  }
  return "insufficient";
}

bool LobeComparison::is_cut() const {
  return std::any_of(energy_missing.begin(), energy_missing.end(), [](double e) { return e > 0; });
}

std::vector<double> LobeComparison::z() const {
  std::vector<double> out(truth.size());
  for (std::size_t k = 0; k < out.size(); ++k) {
    const double error = std::hypot(standard_error[k], model_error.empty() ? 0 : model_error[k]);
    if (error > 0) out[k] = (model[k] - truth[k]) / error;
  }
  return out;
}

double LobeComparison::open_share() const {
  double open = 0, all = 0;
  for (const double e : projection_error) open += e;
  for (const double f : model) all += std::abs(f);
  return open == 0 ? 0 : all > 0 ? open / all : std::numeric_limits<double>::infinity();
}

std::vector<LobeComparison> compare(const RunResult& run, const Simulation* simulation,
                                    const ProjectedLobes& model, bool reflected) {
  std::vector<LobeComparison> lobes;
  const SideResult& side = reflected ? run.reflected : run.transmitted;
  const bool up = (run.incident.z > 0) == reflected;
  const double solid_angle = run.grid.projected_solid_angle();
  for (int o = 0; o < kLobeOrders; ++o) {
    // Without rough interfaces there is no lobe of order 0 to compare with.
    if (!model.has[o] || side.lobes[o].value.empty()) continue;
    LobeComparison l;
    const Simulation* batches = run.is_bounded(static_cast<Order>(o)) ? nullptr : simulation;
    std::optional<ExactFirst> first;
    if (batches && run.order_one == OrderOne::exact &&
        (o == place(Order::all) || o == place(Order::scattered)))
      first.emplace(ExactFirst{side.lobes[Order::one]});
    l.wi = run.incident;
    l.reflected = reflected;
    l.order = static_cast<Order>(o);
    l.truth = side.lobes[o].value;
    l.standard_error = side.lobes[o].standard_error;
    l.model = model.lobes[o];
    l.model_error = noise_of_parts(model.parts, o);
    const std::vector<double>& open = model.errors[o];
    if (std::any_of(open.begin(), open.end(), [](double e) { return e > 0; }))
      l.projection_error = open;
    l.bounded = !batches;
    const std::size_t cells = run.grid.cells(), n = l.truth.size();
    std::vector<int> channel_of(n);
    for (std::size_t k = 0; k < n; ++k) channel_of[k] = static_cast<int>(k / cells);
    BatchSums sums = batches ? lobe_sums(*batches, up, o, single_cells(run.grid, run.channels),
                                         first ? place(Order::two) : place(Order::one))
                             : BatchSums{};
    Means energy = batches ? means_of(grouped(sums, channel_of, run.channels))
                           : Means{grouped_values(l.truth, channel_of, run.channels),
                                   grouped_values(l.standard_error, channel_of, run.channels)};
    if (first) {
      const LobeEstimate& known = first->lobe;
      for (std::size_t k = 0; k < n; ++k) {
        energy.value[channel_of[k]] += known.value[k];
        energy.standard_error[channel_of[k]] += known.standard_error[k];
      }
    }
    const std::vector<double> model_energy = grouped_values(l.model, channel_of, run.channels);
    l.energy_missing = missing_energy(run, l.order);
    std::vector<double> budget;  // of the cells' sums
    if (l.is_cut())
      for (const double energy_missing : l.energy_missing)
        budget.push_back(energy_missing / solid_angle);
    for (int c = 0; c < run.channels; ++c) {
      l.energy_truth.push_back(energy.value[c] * solid_angle);
      l.energy_error.push_back(energy.standard_error[c] * solid_angle);
      l.energy_model.push_back(model_energy[c] * solid_angle);
    }
    double squares = 0, noise = 0, model_noise = 0, truth_squares = 0;
    for (std::size_t k = 0; k < n; ++k) {
      const double d = l.model[k] - l.truth[k];
      squares += d * d / n;
      const double own = l.model_error.empty() ? 0 : l.model_error[k];
      model_noise += own * own / n;
      if (batches) noise += l.standard_error[k] * l.standard_error[k] / n;
      truth_squares += l.truth[k] * l.truth[k] / n;
      l.max_error = std::max(l.max_error, std::abs(d));
      l.empty_cells += batches && l.standard_error[k] == 0;
    }
    const double truth_rms = std::sqrt(std::max(truth_squares - noise, 0.0));
    const auto relative = [&](double x) {
      return truth_rms > 0 ? x / truth_rms : x > 0 ? std::numeric_limits<double>::infinity() : 0;
    };
    l.rmse = std::sqrt(squares);
    l.relative_rmse = relative(l.rmse);
    l.rmse_without_noise = std::sqrt(std::max(squares - noise - model_noise, 0.0));
    l.relative_rmse_without_noise = relative(l.rmse_without_noise);
    l.relative_rmse_least = l.relative_rmse_most = l.relative_rmse_without_noise;
    l.rmse_most = l.rmse_without_noise;
    if (l.is_cut()) {
      const SquaredDifferences range = squared_differences(l.model, l.truth, budget);
      const double least = std::max(range.least - noise - model_noise, 0.0);
      l.relative_rmse_least = std::sqrt(least / most_mean_square(l.truth, budget));
      l.rmse_most = std::sqrt(std::max(range.most - noise - model_noise, 0.0));
      l.relative_rmse_most = relative(l.rmse_most);
    }
    if (batches || !model.parts.empty()) {
      if (!batches) sums = same_in_batches(l.truth, model.parts.size());
      add_noise(sums, model.parts, o);
      std::vector<double> bounds = batches ? std::vector<double>(n) : l.standard_error;
      for (std::size_t k = 0; k < l.projection_error.size(); ++k)
        bounds[k] += l.projection_error[k];
      if (first) first->add_bounds(bounds);
      l.p_value = p_value_of(sums, first ? first->taken_from(l.model) : l.model, bounds, budget,
                             run.grid, run.channels);
    } else {
      l.p_value = is_within_bounds(l) ? 1 : 0;
    }
    lobes.push_back(std::move(l));
  }
  return lobes;
}

void decide(const std::vector<LobeComparison*>& lobes) {
  if (lobes.empty()) return;
  const double level = sidak_level(kReportFalseAlarm, lobes.size());
  for (LobeComparison* l : lobes) {
    if (l->p_value < level) {
      l->verdict = Verdict::differs;
      continue;
    }
    // How large a squared difference the noise could hide, two of its standard deviations up.
    double fourth = 0, squares = 0, noise = 0;
    const double n = static_cast<double>(l->truth.size());
    for (std::size_t k = 0; k < l->truth.size(); ++k) {
      const double variance = l->standard_error[k] * l->standard_error[k];
      const double own = l->model_error.empty() ? 0 : l->model_error[k] * l->model_error[k];
      const double both = (l->bounded ? 0 : variance) + own;
      fourth += both * both;
      noise += variance / n;
      squares += l->truth[k] * l->truth[k] / n;
    }
    // The truth's mean square without the missing light is the least that it can be.
    const double truth = l->bounded ? squares : std::max(squares - noise, 0.0);
    const double seen = l->bounded ? hidden_by_bounds(*l) : l->rmse_most * l->rmse_most;
    const double hidden = seen + 2 * std::sqrt(2 * fourth) / n;
    const bool nothing = squares == 0 && l->rmse == 0 && !l->is_cut();
    l->verdict = nothing || hidden <= kAgreesWithin * kAgreesWithin * truth ? Verdict::agrees
                                                                            : Verdict::insufficient;
  }
}

}  // namespace lamella
