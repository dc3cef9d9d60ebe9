// From an installed Lamella: single scattering of a stack, by the closed form and by the walk, and
// a grid file written and read by the module of OpenVDB. `consumer GRID_FILE`.
#include <cmath>
#include <cstdio>

#include "analytic/layered/single_scattering_model.h"
#include "phase/stack/builtin_stacks.h"
#include "volume/run/simulation.h"
#include "volume/voxels/vdb_file.h"

namespace {

bool grid_file_reads_back(const char* file) {
  using namespace lamella;
  Voxels voxels(VoxelExtent{{8, 8, 8}});
  voxels.density.set({1, 2, 3}, {0.5f});
  write_vdb(file, voxels, {0.1, 0.1, 0.1});
  return read_vdb(file).voxels.density.at({1, 2, 3})[0] == 0.5f;
}

}  // namespace

int main(int, char** arguments) {
  using namespace lamella;
  if (has_openvdb() && !grid_file_reads_back(arguments[1])) return 1;
  const Stack stack = load_stack("isotropic_slab");
  const Direction wi = direction_from_degrees(60, 0), wo = direction_from_degrees(30, 90);
  Simulation simulation(stack, make_plan(stack), wi, {wo}, 1);
  simulation.advance(20000);
  const Estimate walk =
      batch_estimate(simulation.batches(), [](const BatchTally& b) { return b.f[0]; });
  const double exact = single_scattering(stack, wi, wo).layers.r;
  std::printf("%g %g +- %g\n", exact, walk.value, walk.standard_error);
  return std::abs(walk.value - exact) < 5 * walk.standard_error ? 0 : 1;
}
