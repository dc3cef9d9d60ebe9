#include "compare/exchange/projected_lobes.h"

#include <fmt/format.h>

#include "compare/judge/projection.h"
#include "phase/math/degrees.h"

namespace lamella {

LobeSet projected_lobes(const Model& model, const ModelInfo& info,
                        const std::vector<Direction>& directions, const CellGrid& grid,
                        int channels) {
  LobeSet set;
  set.directions = directions;
  set.grid = grid;
  set.channels = channels;
  for (const bool reflected : {true, false}) {
    if (!reflected && !info.transmits) continue;
    std::vector<ProjectedLobes> found;
    for (const Direction wi : directions)
      found.push_back(project(model, info, wi, grid, (wi.z >= 0) == reflected, channels));
    for (int o = 0; o < kLobeOrders; ++o) {
      if (!found.front().has[o]) continue;
      LobeBlock lobe{reflected ? "reflect" : "transmit", to_text(static_cast<Order>(o)), {}, {}};
      for (const ProjectedLobes& p : found) {
        lobe.value.insert(lobe.value.end(), p.lobes[o].begin(), p.lobes[o].end());
        lobe.standard_error.insert(lobe.standard_error.end(), p.errors[o].begin(),
                                   p.errors[o].end());
      }
      set.lobes.push_back(std::move(lobe));
    }
  }
  add_cell_energies(set);
  std::string degrees, vectors;
  for (const Direction w : directions) {
    degrees += fmt::format("{}{},{}", degrees.empty() ? "" : " ", theta_degrees(w), phi_degrees(w));
    vectors += fmt::format("{}{},{},{}", vectors.empty() ? "" : " ", w.x, w.y, w.z);
  }
  set.attributes = {
      {"lamella.version", LAMELLA_VERSION},
      {"lamella.incident", degrees},
      {"lamella.directions", vectors},
      {"lamella.grid", fmt::format("{}x{}", grid.mu_cells, grid.phi_cells)},
      {"lamella.phi", grid.folded
                          ? "folded: columns cover 0 to 180 degrees, each stands for phi and -phi"
                          : "columns cover 0 to 360 degrees"},
      {"lamella.se", "what the projection onto cells left open"},
      {"lamella.conventions",
       "f in 1/sr without the cosine, cosine-weighted mean over each cell; x: azimuth of w_o "
       "relative to w_i from 0; y: mu_o^2 in equal steps, normal incidence at the top; both "
       "directions point away from the stack; wiN: N-th incident direction (theta,phi in "
       "degrees)"}};
  return set;
}

}  // namespace lamella
