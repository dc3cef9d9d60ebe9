// Single scattering of a stack, by the closed form and by the walk, from an installed Lamella.
#include <cmath>
#include <cstdio>

#include "analytic/layered/single_scattering_model.h"
#include "phase/stack/builtin_stacks.h"
#include "volume/run/simulation.h"

int main() {
  using namespace lamella;
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
