#include "compare/judge/lobe_difference.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "compare/judge/lobe_sums.h"
#include "compare/judge/missing_light.h"
#include "compare/judge/statistics.h"

namespace lamella {
namespace {

// `missing`, `other_missing`: per channel, what the sums over the cells of either may be too low
// by; empty where nothing is missing.
double p_value_of(const Simulation& first, const Simulation& second, bool up, int order,
                  const std::vector<double>& missing, const std::vector<double>& other_missing) {
  const CellGrid& grid = first.targets().grid;
  const int channels = first.plan().channels;
  const CellGroups cells = cell_patches(grid, channels);
  const int patches = cells.count;
  const BatchSums a = lobe_sums(first, up, order, cells);
  const BatchSums b = lobe_sums(second, up, order, cells);
  BatchSums both = a, difference = a;
  for (int k = 0; k < a.batches(); ++k)
    for (int p = 0; p < patches; ++p) {
      both.sums[k][p] += b.sums[k][p];
      difference.sums[k][p] -= b.sums[k][p];
    }
  // Neighbours that too few walks reach in both are pooled; if all are too few, they are one.
  std::vector<int> group = pooled_groups(both, kPooledEvents);
  int groups = group.empty() ? 0 : 1 + *std::max_element(group.begin(), group.end());
  if (groups <= 0) {
    group.assign(patches, 0);
    groups = 1;
  }
  if (!missing.empty()) {
    // first - second lies between -missing and other_missing, whatever belongs where.
    const int per_channel = patches / channels;
    const auto beyond = [&](const std::vector<int>& of_patch, int count) {
      std::vector<double> highest(count), width(count);
      std::vector<std::vector<bool>> seen(count, std::vector<bool>(channels));
      for (int p = 0; p < patches; ++p) {
        const int c = p / per_channel, g = of_patch[p];
        if (seen[g][c]) continue;
        seen[g][c] = true;
        highest[g] += other_missing[c];
        width[g] += missing[c] + other_missing[c];
      }
      return largest_deviation_p_value(means_of(grouped(difference, of_patch, count)), highest,
                                       std::vector<double>(count), difference.batches(), width);
    };
    std::vector<int> whole(patches);
    for (int p = 0; p < patches; ++p) whole[p] = p / per_channel;
    return std::min(1.0, 2 * std::min(beyond(group, groups), beyond(whole, channels)));
  }
  const BatchSums pooled = grouped(difference, group, groups);
  const std::vector<double> zero(groups);
  const double broad = hotelling_p_value(pooled, zero, zero);
  const double local = largest_deviation_p_value(means_of(pooled), zero, zero, pooled.batches());
  return std::min(1.0, 2 * std::min(broad, local));
}

}  // namespace

std::vector<LobeDifference> differences(const Simulation& first, const Simulation& second) {
  const RunResult a = reduce(first), b = reduce(second);
  std::vector<LobeDifference> lobes;
  for (const bool reflected : {true, false}) {
    const SideResult& sa = reflected ? a.reflected : a.transmitted;
    const SideResult& sb = reflected ? b.reflected : b.transmitted;
    if (sa.lobes[0].value.empty()) continue;
    for (int o = 0; o <= kTallyOrders; ++o) {
      LobeDifference l;
      l.wi = a.incident;
      l.reflected = reflected;
      l.order = o;
      for (int c = 0; c < a.channels; ++c) {
        const Estimate ea = o < kTallyOrders ? sa.orders[o][c] : sa.total[c];
        const Estimate eb = o < kTallyOrders ? sb.orders[o][c] : sb.total[c];
        l.energy.push_back(ea.value);
        l.energy_error.push_back(ea.standard_error);
        l.energy_other.push_back(eb.value);
        l.energy_other_error.push_back(eb.standard_error);
      }
      const LobeEstimate &fa = sa.lobes[o], &fb = sb.lobes[o];
      const double n = static_cast<double>(fa.value.size());
      double squares = 0, noise = 0, own = 0, own_noise = 0, fourth = 0;
      for (std::size_t k = 0; k < fa.value.size(); ++k) {
        const double d = fa.value[k] - fb.value[k];
        const double va = fa.standard_error[k] * fa.standard_error[k];
        const double v = va + fb.standard_error[k] * fb.standard_error[k];
        squares += d * d / n;
        noise += v / n;
        fourth += v * v;
        own += fa.value[k] * fa.value[k] / n;
        own_noise += va / n;
      }
      const auto order = static_cast<Order>(o);
      l.energy_missing = missing_energy(a, order);
      l.energy_other_missing = missing_energy(b, order);
      const bool cut = is_cut(a, order) || is_cut(b, order);
      // The most that missing light adds to the mean square: all of either in one cell.
      double added = 0;
      std::vector<double> budget, other_budget;
      for (int c = 0; cut && c < a.channels; ++c) {
        budget.push_back(l.energy_missing[c] / a.grid.projected_solid_angle());
        other_budget.push_back(l.energy_other_missing[c] / a.grid.projected_solid_angle());
        double highest = 0, lowest = 0;
        const std::size_t cells = fa.value.size() / a.channels;
        for (std::size_t k = c * cells; k < (c + 1) * cells; ++k) {
          highest = std::max(highest, fa.value[k] - fb.value[k]);
          lowest = std::min(lowest, fa.value[k] - fb.value[k]);
        }
        added += (budget.back() * (budget.back() + 2 * highest) +
                  other_budget.back() * (other_budget.back() - 2 * lowest)) /
                 n;
      }
      const double signal = std::max(squares - noise, 0.0), power = std::max(own - own_noise, 0.0);
      const double infinity = std::numeric_limits<double>::infinity();
      l.relative_rmse_without_noise = signal == 0 ? 0
                                      : power > 0 ? std::sqrt(signal / power)
                                                  : infinity;
      const double hidden = signal + added + 2 * std::sqrt(2 * fourth) / n;
      l.hidden = hidden == 0 ? 0 : power > 0 ? hidden / power : infinity;
      l.p_value =
          p_value_of(first, second, (a.incident.z > 0) == reflected, o, budget, other_budget);
      lobes.push_back(std::move(l));
    }
  }
  return lobes;
}

void decide(std::vector<LobeDifference>& lobes) {
  if (lobes.empty()) return;
  const double level = sidak_level(kReportFalseAlarm, lobes.size());
  for (LobeDifference& l : lobes)
    l.verdict = l.p_value < level                           ? Verdict::differs
                : l.hidden <= kAgreesWithin * kAgreesWithin ? Verdict::agrees
                                                            : Verdict::insufficient;
}

}  // namespace lamella
