#include "compare/judge/side_by_side.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "compare/fit/fitted_models.h"
#include "compare/judge/projection.h"
#include "compare/request/model_request.h"
#include "compare/request/percent.h"
#include "phase/math/degrees.h"
#include "phase/math/luminance.h"
#include "volume/grains/grain_measure.h"
#include "volume/run/simulation.h"

namespace lamella {
namespace {

constexpr std::uint64_t kRealisations = 64, kRays = 2000;
// A medium is walked much faster than grains: its noise need not show.
constexpr std::uint64_t kMoreWalks = 4;

/// Of a lobe, [channel][cell]; cells have equal projected solid angles, pi in all.
double energy_of(const std::vector<double>& lobe, int channels) {
  std::vector<double> energies(static_cast<std::size_t>(channels));
  const std::size_t cells = lobe.size() / energies.size();
  for (std::size_t k = 0; k < lobe.size(); ++k)
    energies[k / cells] += lobe[k] * kPi / static_cast<double>(cells);
  return luminance(energies);
}

RunResult walked(const TruthRequest& medium, const RunResult& like, const StopFlag* stop) {
  Simulation simulation(medium.stack, plan_of(medium), like.incident, Estimator::analog, like.grid,
                        medium.seed + 1);
  run(simulation, {.walks = kMoreWalks * like.walks, .target_error = {}, .seconds = {}}, {}, stop);
  return reduce(simulation);
}

}  // namespace

RelativeError relative_error(const LobeEstimate& truth, const std::vector<double>& other,
                             const std::vector<double>& other_error) {
  double difference = 0, noise = 0, square = 0, own_noise = 0;
  for (std::size_t k = 0; k < truth.value.size(); ++k) {
    const double d = other[k] - truth.value[k];
    difference += d * d;
    square += truth.value[k] * truth.value[k];
    own_noise += truth.standard_error[k] * truth.standard_error[k];
    if (!other_error.empty()) noise += other_error[k] * other_error[k];
  }
  noise += own_noise;
  const double signal = std::max(0.0, square - own_noise);
  const auto relative = [&](double squares) {
    return signal > 0    ? std::sqrt(squares / signal)
           : squares > 0 ? std::numeric_limits<double>::infinity()
                         : 0;
  };
  return {relative(std::max(0.0, difference - noise)), relative(noise)};
}

std::vector<SideBySide> side_by_side(const TruthRequest& request,
                                     const std::vector<RunResult>& runs, const StopFlag* stop) {
  const Stack& stack = request.stack;
  const GrainMeasurement measured =
      measure_grains(*stack.grains(), request.seed, kRealisations, kRays);
  std::vector<SideBySide> rows;
  for (const Equivalent kind :
       {Equivalent::lambert_sphere, Equivalent::vmf_flake, Equivalent::sggx}) {
    Stack medium;
    try {
      medium = equivalent_stack(stack, measured, kind);
    } catch (const std::invalid_argument&) {
      continue;  // no such medium for these grains
    }
    const std::vector<BoundModel> models = fitted_models_for({}, medium);
    TruthRequest of_medium = request;
    of_medium.stack = medium;
    for (const RunResult& grains : runs) {
      if (is_set(stop)) return rows;
      // Light from below has no counterpart where the medium became a half space.
      if (grains.incident.z < 0 && !medium.is_open_below()) continue;
      const RunResult flat = walked(of_medium, grains, stop);
      const bool up = grains.incident.z > 0;
      std::vector<ProjectedLobes> projections;
      for (const BoundModel& m : models)
        projections.push_back(
            project(*m.model, *m.info, grains.incident, flat.grid, up, flat.channels));
      for (int o = 0; o <= kTallyOrders; ++o) {
        const LobeEstimate &g = grains.reflected.lobes[o], &f = flat.reflected.lobes[o];
        if (g.value.size() != f.value.size()) continue;  // grey here, coloured there
        SideBySide row{.wi = grains.incident,
                       .medium = medium.layers[0].medium_name,
                       .model = {},
                       .order = static_cast<Order>(o),
                       .energy_geometry = energy_of(g.value, grains.channels),
                       .energy_medium = energy_of(f.value, flat.channels),
                       .medium_error = relative_error(g, f.value, f.standard_error),
                       .model_error = {},
                       .total_error = {}};
        bool any = false;
        for (std::size_t k = 0; k < models.size(); ++k) {
          const ProjectedLobes& p = projections[k];
          if (!p.has[o] || (o == kTallyOrders && models[k].info->name == "single_scattering"))
            continue;
          any = true;
          row.model = models[k].info->name;
          row.energy_model = energy_of(p.lobes[o], flat.channels);
          row.model_error = relative_error(f, p.lobes[o]);
          row.total_error = relative_error(g, p.lobes[o]);
          rows.push_back(row);
        }
        if (!any) rows.push_back(row);
      }
    }
  }
  return rows;
}

std::string side_by_side_table(const std::vector<SideBySide>& rows) {
  std::string text =
      "\nThe geometry, a medium measured from it, a closed form of that medium; rel. RMSE without "
      "noise of\n  (a) the medium, over the geometry's root mean square, (b) the form, over the "
      "medium's, (c) the form, over the geometry's\n";
  text += fmt::format("  {:>7} {:>5} {:>9} | {:<14} {:>9} {:>9} | {:<30} {:>9} {:>9} {:>9} {:>9}\n",
                      "theta_i", "order", "geometry", "medium", "energy", "(a)", "closed form",
                      "energy", "(b)", "(c)", "noise");
  for (const SideBySide& r : rows) {
    text += fmt::format("  {:>7g} {:>5} {:>9.5f} | {:<14} {:>9.5f} {:>9} | ", theta_degrees(r.wi),
                        to_text(r.order), r.energy_geometry, r.medium, r.energy_medium,
                        percent_cell(r.medium_error.rmse));
    if (r.model.empty())
      text += fmt::format("{:<30} {:>9} {:>9} {:>9} {:>9}\n", "-", "", "", "",
                          percent_cell(r.medium_error.noise));
    else
      text += fmt::format("{:<30} {:>9.5f} {:>9} {:>9} {:>9}\n", r.model, r.energy_model,
                          percent_cell(r.model_error.rmse), percent_cell(r.total_error.rmse),
                          percent_cell(r.medium_error.noise));
  }
  return text;
}

}  // namespace lamella
