#include "compare/judge/projection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <string>

#include "analytic/model/model.h"
#include "compare/truth/lobe_cells.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

double energy_of(const Model& model, const ModelInfo& info, Direction wi, const CellGrid& grid) {
  const ProjectedLobes lobes = project(model, info, wi, grid, true, 1);
  const std::vector<double>& all = lobes.lobes[Order::all];
  return std::accumulate(all.begin(), all.end(), 0.0) * grid.projected_solid_angle();
}

// A mirror's lobe that is hundreds of times narrower than a cell has the energy that an adaptive
// quadrature of another kind finds, whatever the cells.
TEST(Projection, MeetsPeaksThatAreNarrowerThanItsPoints) {
  const ModelInfo& info = *find_model("single_scattering");
  for (const double roughness : {0.002, 0.01, 0.05})
    for (const double theta : {0.0, 33.0, 71.0}) {
      const Stack stack =
          parse_stack("[[layer]]\nmedium = \"sggx\"\nroughness = " + std::to_string(roughness) +
                          "\nthickness = 1\n",
                      "test", "test");
      const auto model = info.make({}, &stack);
      const Direction wi = direction_from_degrees(theta, 0);
      // Of reciprocal f: light from wi to all is as much as light from all to wi.
      const double expected =
          lobe_cells([&](Direction wo) { return model->eval(wo, wi); }, wi.z).energy.r;
      for (const CellGrid grid : {CellGrid{4, 8, false}, {16, 32, false}, {15, 31, false}})
        EXPECT_NEAR(energy_of(*model, info, wi, grid) / expected, 1, 2e-3)
            << "roughness " << roughness << ", theta_i " << theta << ", " << grid.mu_cells;
    }
}

}  // namespace
}  // namespace lamella
