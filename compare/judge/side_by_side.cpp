#include "compare/judge/side_by_side.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "compare/fit/fitted_models.h"
#include "compare/judge/missing_light.h"
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

// The most that light which cut walks held adds to the sum of the cells' squares: all of it in one
// cell, of every channel.
double missing_square(const RunResult& run, Order order) {
  double sum = 0;
  for (const double energy : missing_energy(run, order)) {
    const double f = energy / run.grid.projected_solid_angle();
    sum += f * f;
  }
  return sum;
}

RunResult walked(const TruthRequest& medium, const RunResult& like, const StopFlag* stop) {
  Simulation simulation(medium.stack, plan_of(medium), like.incident, Estimator::analog, like.grid,
                        medium.seed + 1);
  run(simulation, {.walks = kMoreWalks * like.walks, .target_error = {}, .seconds = {}}, {}, stop);
  return reduce(simulation);
}

}  // namespace

RelativeError relative_error(const LobeEstimate& truth, const std::vector<double>& other,
                             const std::vector<double>& other_error, double missing_square) {
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
  return {relative(std::max(0.0, difference - noise)), relative(noise + missing_square)};
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
        const auto order = static_cast<Order>(o);
        SideBySide row{.wi = grains.incident,
                       .medium = medium.layers[0].medium_name,
                       .model = {},
                       .order = order,
                       .energy_geometry = energy_of(g.value, grains.channels),
                       .energy_medium = energy_of(f.value, flat.channels),
                       .energy_missing = std::max(luminance(missing_energy(grains, order)),
                                                  luminance(missing_energy(flat, order))),
                       .medium_error = relative_error(
                           g, f.value, f.standard_error,
                           missing_square(grains, order) + missing_square(flat, order)),
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
          row.model_error = relative_error(f, p.lobes[o], {}, missing_square(flat, order));
          row.total_error = relative_error(g, p.lobes[o], {}, missing_square(grains, order));
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
      "\nThe geometry, a medium measured from it, closed forms of that medium; rel. RMSE without "
      "noise of\n  (a) the medium, over the geometry's root mean square, (b) the form, over the "
      "medium's,\n  (c) the form, over the geometry's; noise: of (a), with what cut walks lack\n";
  text += fmt::format("  {:>7} {:>5}  {:<34} {:>8} {:>9} {:>9} {:>9} {:>9}\n", "theta_i", "order",
                      "medium, form", "energy", "(a)", "(b)", "(c)", "noise");
  const SideBySide* last = nullptr;
  for (const SideBySide& r : rows) {
    const bool same = last && dot(last->wi - r.wi, last->wi - r.wi) == 0 &&
                      last->medium == r.medium && last->order == r.order;
    if (!same)
      text += fmt::format("  {:>7g} {:>5}  {:<34} {:>8.5f} {:>9} {:>9} {:>9} {:>9}\n",
                          theta_degrees(r.wi), to_text(r.order),
                          fmt::format("{}, geometry {:.5f}", r.medium, r.energy_geometry),
                          r.energy_medium, percent_cell(r.medium_error.rmse), "", "",
                          percent_cell(r.medium_error.noise));
    last = &r;
    if (!r.model.empty())
      text += fmt::format("  {:>7} {:>5}    {:<32} {:>8.5f} {:>9} {:>9} {:>9}\n", "", "", r.model,
                          r.energy_model, "", percent_cell(r.model_error.rmse),
                          percent_cell(r.total_error.rmse));
  }
  return text;
}

}  // namespace lamella
