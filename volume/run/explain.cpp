#include "volume/run/explain.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "volume/grains/grain_walk.h"
#include "volume/grid_walk/grid_lane_run.h"
#include "volume/lanes/lane_run.h"
#include "volume/lanes/lane_setting.h"
#include "volume/plan/longest_walk.h"
#include "volume/run/simulation.h"
#include "volume/voxels/density_grid.h"
#include "volume/voxels/ray_table.h"

namespace lamella {
namespace {

void explain_grid(const Layer& layer, const DensityGrid& grid, std::size_t k,
                  std::vector<PlanNote>& notes) {
  const VoxelIndex n = grid.extent().voxels;
  const DensityGrid::CellCount count = grid.count_cells();
  std::string varies = "density";
  if (grid.has_orientation()) varies += ", orientation";
  if (grid.has_roughness()) varies += ", roughness";
  if (grid.has_albedo()) varies += ", albedo";
  notes.push_back({"grid",
                   fmt::format("layer {}: {} from {}, delta tracking", k, varies, layer.grid->file),
                   fmt::format("{} x {} x {} voxels; {} of {} blocks are empty; {} cells with a "
                               "majorant each are the fastest to cross",
                               n[0], n[1], n[2], count.empty_blocks, count.blocks, count.cells)});
  if (!grid.extent_source().empty())
    notes.push_back({"grid",
                     fmt::format("layer {}: a tile of {} x {} x {} voxels of {:.4g} x {:.4g} x "
                                 "{:.4g} mm",
                                 k, n[0], n[1], n[2], grid.voxel_size().x, grid.voxel_size().y,
                                 grid.voxel_size().z),
                     "by " + grid.extent_source()});
  for (std::size_t g = 0; g < layer.grid->names.size(); ++g)
    if (!layer.grid->names[g].empty())
      notes.push_back(
          {"grid", fmt::format("layer {}: {} = \"{}\"", k, kGridNameKeys[g], layer.grid->names[g]),
           "the layer names it"});
  const Voxels& voxels = grid.voxels();
  if (voxels.orientation && !grid.has_orientation())
    notes.push_back(
        {"grid", fmt::format("layer {}: orientation left out", k), "particles have no axis"});
  if (voxels.albedo && !grid.has_albedo())
    notes.push_back({"grid", fmt::format("layer {}: albedo left out", k),
                     layer.grid->white ? "grid_albedo is white" : "it is 1 everywhere"});
  if (grid.roughness_error() > 0)
    notes.push_back({"grid",
                     fmt::format("layer {}: roughness rounded to {} levels, off by at most {:.1g}",
                                 k, grid.palette().size(), grid.roughness_error()),
                     "a medium per roughness is kept"});
}

PlanNote ensemble_note(const Stack& stack) {
  return {"ensemble",
          fmt::format("a new realisation every {} walks of a batch, turned by a random angle",
                      GrainSetting(stack, {0, 0, 1}, 1, 1).walks_per_realisation),
          "standard errors come from the scatter across realisations; light enters over the whole "
          "tile"};
}

void explain_height_field(const Stack& stack, const GrainGeometry& field,
                          std::vector<PlanNote>& notes) {
  notes.push_back({"geometry",
                   fmt::format("rays are traced over {:g} triangles in a tile of {:.6g} mm that "
                               "repeats in x and y",
                               field.expected_count(), field.tile),
                   "heights are Gaussian, and neighbours share them; Smith's surface (scattering = "
                   "\"multiple\") has the same slopes at heights of their own"});
  notes.push_back(ensemble_note(stack));
  notes.push_back({"below", "no transmission tallies", "nothing passes the surface"});
  notes.push_back({"reciprocity", "of reflection", "of the mean over realisations"});
}

void explain_grains(const Stack& stack, const GrainGeometry& grains, std::vector<PlanNote>& notes) {
  if (grains.is_height_field()) return explain_height_field(stack, grains, notes);
  notes.push_back(
      {"geometry",
       fmt::format("rays are traced among explicit grains: {} ({:.6g} in a tile of {:.6g} mm that "
                   "repeats in x and y)",
                   stack.layers[0].medium_name, grains.expected_count(), grains.tile),
       "no medium stands for them; what a path meets twice because of the period is of the order "
       "of one grain in all of the tile's"});
  notes.push_back(ensemble_note(stack));
  if (stack.substrate)
    notes.push_back(
        {"below",
         fmt::format("an opaque plane at z = {:.6g} mm that reflects by {}, no "
                     "transmission tallies",
                     grains.bottom(),
                     stack.substrate->model.empty() ? "Lambert's law" : stack.substrate->model),
         grains.is_bed() ? "a substrate below the lowest spheres; its reflection counts "
                           "as an order"
                         : "the plane that the grains stand on; its reflection counts "
                           "as an order"});
  else
    notes.push_back({"below", "transmission tallies: what leaks through a bed is counted there",
                     "no substrate"});
  notes.push_back({"reciprocity", "of reflection and transmission",
                   "of the mean over realisations: grains and substrate are reciprocal"});
}

void explain_grid_lanes(const Stack& stack, const Plan& plan, std::vector<PlanNote>& notes) {
  const auto& grid = plan.grids[plan.layers[0]];
  const auto reason =
      GridLaneRun::why_not(stack, plan, grid ? make_ray_table(*grid).get() : nullptr);
  notes.push_back(
      reason ? PlanNote{"instructions", "scalar kernel, double precision", *reason}
             : PlanNote{
                   "instructions",
                   fmt::format("{} lanes, single precision, for counted walks", to_text(plan.isa)),
                   "next-event estimation follows its walks in double and sends shadow rays"});
}

void explain_lanes(const Stack& stack, const Plan& plan, std::vector<PlanNote>& notes) {
  if (plan.has_grids() && !plan.layers.empty()) return explain_grid_lanes(stack, plan, notes);
  if (const auto reason = why_not_lanes(stack, plan)) {
    notes.push_back({"instructions", "scalar kernel, double precision", *reason});
    return;
  }
  notes.push_back(
      {"instructions", fmt::format("{} lanes, single precision", to_text(plan.isa)),
       "float resolves all depths and media (the same walks in double differ by 1e-6 in "
       "the mean of hard cases, see volume/README.md); the first collision is forced "
       "where its chance is below 5 %"});
  if (const auto reason = why_not_lanes_in_cells(stack, plan, CellGrid{}))
    notes.push_back({"instructions", "scalar kernel for next-event estimation in cells", *reason});
  const bool common = LaneSetting<double>(stack, plan, {0, 0, 1}, 0).common_albedo;
  notes.push_back(
      common ? PlanNote{"weights",
                        plan.channels == 1 ? "none: a walk's order tells its weight"
                                           : "none: colours are recombined from orders, c^k f_k",
                        plan.layers.empty() ? "the substrate's albedo is the only one"
                                            : "one albedo in all layers, no Fresnel factor, no "
                                              "substrate"}
             : PlanNote{"weights", "carried by each walk, one per channel",
                        "albedos differ, or a Fresnel factor or substrate takes its "
                        "share"});
}

}  // namespace

namespace {

void explain_boundaries(const Stack& stack, std::vector<PlanNote>& notes) {
  // Below this alpha a cell, and a point's f, sees the lobe as next to a delta.
  constexpr double kNarrow = 0.01;
  double index = 1;
  for (std::size_t k = 0; k < stack.layers.size(); ++k) {
    const auto& i = stack.layers[k].interface;
    if (!i) continue;
    const bool smooth = i->facets.shape == FacetShape::smooth;
    const double alpha = std::min(i->facets.alpha_x, i->facets.alpha_y);
    if (i->ior == index)
      notes.push_back({fmt::format("interface {}", k), "left out", "the index does not change"});
    else
      notes.push_back(
          {fmt::format("interface {}", k),
           smooth
               ? fmt::format("smooth, index {:g} to {:g}: Fresnel decides by chance, Snell turns",
                             index, i->ior)
               : fmt::format("{}, alpha {:g}{}, index {:g} to {:g}, {} scattering",
                             to_text(i->facets.shape), i->facets.alpha_x,
                             i->facets.alpha_x == i->facets.alpha_y
                                 ? ""
                                 : fmt::format(" and {:g}", i->facets.alpha_y),
                             index, i->ior, i->multiple ? "multiple" : "single"),
           smooth ? "light that meets smooth interfaces alone is a delta: specular, or uncollided"
           : i->multiple ? "Smith's walk over heights loses nothing"
           : alpha < kNarrow
               ? "so narrow a lobe of order 0 is resolved by few cells; what facets hide is lost"
               : fmt::format("masking {}; what facets hide is lost", to_text(i->masking))});
    index = i->ior;
  }
}

}  // namespace

std::vector<PlanNote> explain(const Stack& stack, const Plan& plan) {
  std::vector<PlanNote> notes;
  notes.push_back(
      plan.channels == 1
          ? PlanNote{"colour", "one weight channel", "every albedo, f0 and substrate is grey"}
          : PlanNote{"colour", "three weight channels, one walk",
                     "an albedo, f0 or substrate differs between channels"});
  notes.push_back(
      plan.folded
          ? PlanNote{"azimuth", "phi folded onto [0, 180]; the incident azimuth does not matter",
                     stack.grains() ? "the ensemble of realisations is symmetric about the normal"
                                    : "every layer is symmetric about the normal"}
          : PlanNote{"azimuth", "the whole circle of phi", "a layer is not symmetric about z"});
  if (const GrainGeometry* grains = stack.grains()) {
    explain_grains(stack, *grains, notes);
    notes.push_back({"orders", fmt::format("1, 2, 3, 4+; cut after {} events", plan.max_order),
                     "what is cut is reported as unresolved"});
    return notes;
  }
  if (plan.boundaries) explain_boundaries(stack, notes);
  const auto interfaces = std::count_if(stack.layers.begin(), stack.layers.end(),
                                        [](const Layer& l) { return l.interface.has_value(); });
  const std::size_t empty =
      stack.layers.size() - plan.layers.size() - static_cast<std::size_t>(interfaces);
  notes.push_back({"layers",
                   plan.layers.empty() ? "none is walked"
                   : plan.single_layer
                       ? "one: no layer is looked up"
                       : fmt::format("{}: free flight crosses {} exactly", plan.layers.size(),
                                     plan.has_grids() ? "homogeneous ones" : "them"),
                   empty                 ? fmt::format("{} of depth 0 left out", empty)
                   : plan.layers.empty() ? "no layer holds a medium"
                                         : "all have depth"});
  for (std::size_t k = 0; k < plan.grids.size(); ++k)
    if (plan.grids[k]) explain_grid(stack.layers[k], *plan.grids[k], k, notes);
  if (plan.has_grids())
    notes.push_back({"place", "x and y in the tile of all grids; light enters all over it",
                     "f is the mean over the tile"});
  if (plan.has_grids() && plan.isa != Isa::scalar) {
    const bool on_lanes = std::all_of(plan.grids.begin(), plan.grids.end(), [](const auto& grid) {
      return !grid || make_ray_table(*grid);
    });
    notes.push_back(
        on_lanes
            ? PlanNote{"shadow rays", fmt::format("{} lanes, single precision", to_text(plan.isa)),
                       "next-event estimation follows hundreds of rays through a grid at once"}
            : PlanNote{"shadow rays", "scalar, double precision",
                       "lanes have no table for a grid of one-sided flakes that are turned, of "
                       "roughness alone, or of very many voxels"});
  }
  if (plan.uniform_medium)
    notes.push_back({"medium", "kernel of " + stack.layers[plan.layers[0]].medium_name,
                     "all layers hold the same kind of medium"});
  else if (!plan.layers.empty())
    notes.push_back({"medium", "medium looked up at every event", "layers hold different media"});
  if (stack.is_half_space())
    notes.push_back({"below", "no transmission tallies", "the last layer is infinite"});
  else if (stack.substrate && !stack.substrate->model.empty())
    notes.push_back({"below",
                     "reflection by " + stack.substrate->model + ", no transmission tallies",
                     "an opaque substrate; its reflection counts as an order"});
  else if (stack.substrate)
    notes.push_back(
        stack.substrate->albedo.max() > 0
            ? PlanNote{"below", "Lambertian reflection, no transmission tallies",
                       "an opaque substrate; its reflection counts as an order"}
            : PlanNote{"below", "absorbed, no transmission tallies", "a black substrate"});
  else
    notes.push_back({"below", "transmission tallies; light from below is allowed",
                     "finite layers without a substrate"});
  const bool fresnel = std::any_of(stack.layers.begin(), stack.layers.end(),
                                   [](const Layer& l) { return l.f0 != Rgb(1); });
  notes.push_back(fresnel ? PlanNote{"Fresnel", "Schlick's factor at each event", "an f0 below 1"}
                          : PlanNote{"Fresnel", "left out", "no f0 below 1"});
  const double one_sided = stack.one_sidedness();
  const bool closed_form =
      stack.substrate && !stack.substrate->model.empty() && stack.substrate->model != kConductor;
  notes.push_back(
      !stack.is_reciprocal()
          ? PlanNote{"reciprocity", "not claimed",
                     closed_form ? "closed forms as substrates are not asked whether they are"
                                 : "a one-sided layer's mean normal is tilted"}
      : one_sided != 0
          ? PlanNote{"reciprocity", "of reflection",
                     fmt::format("one-sided flakes: transmission from above is exp(-{:.6g}) times "
                                 "that from below",
                                 one_sided)}
          : PlanNote{"reciprocity",
                     stack.has_interfaces() ? "of reflection, and of transmission by f / n^2"
                                            : "of reflection and transmission",
                     "all media are two-sided"});
  notes.push_back({"orders",
                   fmt::format("{}1, 2, 3, 4+; cut after {} events", plan.boundaries ? "0, " : "",
                               plan.max_order),
                   stack.is_half_space() ? "a half space keeps some walks for ever: their share is "
                                           "reported as unresolved"
                                         : "what is cut is reported as unresolved"});
  if (plan.thinning.is_on())
    notes.push_back(
        {"long walks",
         fmt::format("thinned: after {} events and every fourfold of that half of them "
                     "end, and the others count double",
                     plan.thinning.first),
         fmt::format("the longest walks have {} events, most of the time for little of the light; "
                     "the mean stays, energies of all orders have larger errors for it "
                     "(--thin-from 0)",
                     std::isfinite(longest_walk(stack, plan.layers))
                         ? fmt::format("about {:.2g}", longest_walk(stack, plan.layers))
                         : "any number of")});
  if (plan.order_one == OrderOne::exact) {
    const auto reason = why_no_closed_first(stack);
    notes.push_back(
        {"order 1", reason ? "counted by walks" : "exact; walks count it as a check",
         reason.value_or(fmt::format("a closed form, at points and in cells from {} walks per cell "
                                     "and side on, {} at least, or {} next-event walks "
                                     "(--walk-order-1)",
                                     kCountedPerClosedCell, kCountedForClosedCells,
                                     kNextEventForClosedCells))});
  }
  explain_lanes(stack, plan, notes);
  if (plan.sampling == Sampling::rqmc)
    notes.push_back({"sampling",
                     "randomised quasi-Monte Carlo for the first steps of walks on lanes, in grids "
                     "and among grains",
                     "a batch's walks fill the space of their numbers evenly (--sampling random)"});
  return notes;
}

}  // namespace lamella
