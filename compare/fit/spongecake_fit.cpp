#include "compare/fit/spongecake_fit.h"

#include <fmt/format.h>

#include <cmath>

#include "analytic/layered/spongecake.h"
#include "phase/math/luminance.h"
#include "phase/stack/single_scattering.h"

namespace lamella {
namespace {

// Standard errors of the energy that cut walks held which are added to it (judge/missing_light.h).
constexpr double kUnresolvedErrors = 3;
// Per channel, how much the energy of a run's orders 2 and up may be too low, as walks were cut.
Rgb missing_energy(const RunResult& run) {
  Rgb missing;
  for (int c = 0; c < 3; ++c) {
    const Estimate& cut = run.unresolved[run.channels == 3 ? c : 0];
    if (!run.is_bounded() && cut.value > 0)
      missing[c] = std::min(1.0, cut.value + kUnresolvedErrors * cut.standard_error);
  }
  return missing;
}

// A cell, and the residue that it belongs to.
struct Cells {
  std::vector<LobeCell> cells;
  std::vector<std::size_t> residue;
};

Cells cells_of(const Stack& stack, const std::vector<RunResult>& runs,
               std::vector<SpongecakeResidue>& residues) {
  const int parts = cell_parts(stack);
  Cells all;
  for (const RunResult& run : runs)
    for (const bool reflected : {true, false}) {
      const SideResult& side = reflected ? run.reflected : run.transmitted;
      if (side.lobes[0].value.empty()) continue;
      const std::size_t count = run.grid.cells();
      const LobeEstimate& lobe = side.lobes[Order::multiple];
      for (std::size_t k = 0; k < count; ++k) {
        LobeCell cell{
            .wi = run.incident,
            .wo = cell_nodes(run.incident, static_cast<int>(k) / run.grid.columns(),
                             static_cast<int>(k) % run.grid.columns(), run.grid.mu_cells,
                             run.grid.phi_cells, (run.incident.z > 0) == reflected, parts),
            .reflected = reflected};
        for (int c = 0; c < 3; ++c) {
          const std::size_t at = (run.channels == 3 ? c : 0) * count + k;
          cell.truth[c] = lobe.value[at];
          cell.variance[c] = std::pow(lobe.standard_error[at], 2);
        }
        all.cells.push_back(cell);
        all.residue.push_back(residues.size());
      }
      residues.push_back({.wi = run.incident,
                          .reflected = reflected,
                          .energy_missing = luminance(missing_energy(run))});
    }
  return all;
}

std::string text_of(Rgb c) {
  return c.is_grey() ? fmt::format("{:.6g}", c.r)
                     : fmt::format("{:.6g},{:.6g},{:.6g}", c.r, c.g, c.b);
}

}  // namespace

std::string lobes_request(const Stack& stack, const SpongecakeLobes& lobes) {
  std::string text =
      fmt::format("spongecake,second_weight=1,lambert_reflect={}", text_of(lobes.reflect));
  if (stack.is_open_below()) text += fmt::format(",lambert_transmit={}", text_of(lobes.transmit));
  for (std::size_t k = 0; k < lobes.factors.size(); ++k) {
    const SpongecakeFactors& f = lobes.factors[k];
    if (f.roughness != 1) text += fmt::format(",second_roughness_{}={:.6g}", k + 1, f.roughness);
    if (f.depth != 1) text += fmt::format(",second_depth_{}={:.6g}", k + 1, f.depth);
    text += fmt::format(",second_albedo_{}={}", k + 1, text_of(f.albedo));
    if (f.f0 != Rgb(1)) text += fmt::format(",second_f0_{}={}", k + 1, text_of(f.f0));
  }
  return text;
}

SpongecakeFit fit_spongecake(const Stack& stack, const std::vector<RunResult>& runs) {
  SpongecakeFit fit;
  const Cells all = cells_of(stack, runs, fit.residues);
  const std::vector<LobeCell>& cells = all.cells;
  const int channels = runs.front().channels;
  double square = 0;
  for (const LobeCell& cell : cells)
    for (int c = 0; c < channels; ++c) square += cell.truth[c] * cell.truth[c];
  const TwoLobeFit found = fit_two_lobes(stack, cells, channels);
  fit.iterations = found.iterations;
  fit.lobes = found.lobes;
  fit.request = lobes_request(stack, found.lobes);

  const Stack second = spongecake_second_stack(stack, found.lobes.factors);
  std::vector<Rgb> values;
  for (const LobeCell& cell : cells) values.push_back(value_of(second, found.lobes, cell));
  std::vector<double> error(fit.residues.size()), truth(fit.residues.size()),
      noise(fit.residues.size());
  double all_error = 0, all_noise = 0;
  std::vector<double> counts(fit.residues.size());
  for (std::size_t k = 0; k < cells.size(); ++k)
    for (int c = 0; c < channels; ++c) {
      const std::size_t r = all.residue[k];
      error[r] += std::pow(values[k][c] - cells[k].truth[c], 2);
      truth[r] += std::pow(cells[k].truth[c], 2);
      noise[r] += cells[k].variance[c];
      const double weight = channels == 1 ? 1 : kLuminanceWeights[static_cast<std::size_t>(c)];
      counts[r] += weight;
      fit.residues[r].energy_truth += kPi * weight * cells[k].truth[c];
      fit.residues[r].energy_model += kPi * weight * values[k][c];
    }
  double walk_noise = 0;
  for (const double n : noise) walk_noise += n;
  fit.walk_noise = std::sqrt(walk_noise / square);
  // What cut walks held belongs to an unknown place: at worst to one cell of each side.
  std::size_t next = 0;
  for (const RunResult& run : runs)
    for (const SideResult* side : {&run.reflected, &run.transmitted}) {
      if (side->lobes[0].value.empty()) continue;
      const Rgb missing = missing_energy(run);
      for (int c = 0; c < channels; ++c)
        noise[next] += std::pow(missing[c] / run.grid.projected_solid_angle(), 2);
      ++next;
    }
  for (std::size_t r = 0; r < fit.residues.size(); ++r) {
    SpongecakeResidue& residue = fit.residues[r];
    residue.energy_truth /= counts[r];
    residue.energy_model /= counts[r];
    residue.relative_rmse = truth[r] > 0 ? std::sqrt(error[r] / truth[r]) : 0;
    residue.noise = truth[r] > 0 ? std::sqrt(noise[r] / truth[r]) : 0;
    all_error += error[r];
    all_noise += noise[r];
  }
  fit.relative_rmse = std::sqrt(all_error / square);
  fit.noise = std::sqrt(all_noise / square);
  return fit;
}

}  // namespace lamella
