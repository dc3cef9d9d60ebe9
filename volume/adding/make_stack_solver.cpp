#include "volume/adding/make_stack_solver.h"

#include <vector>

#include "volume/adding/pile_modes.h"
#include "volume/adding/stack_modes.h"

namespace lamella {

std::unique_ptr<StackSolver> make_stack_solver(const Stack& stack, int channel, int nodes,
                                               std::span<const AskedCosine> asked_out,
                                               std::span<const AskedCosine> asked_in, int orders,
                                               Isa isa) {
  if (stack.has_boundaries())
    return std::make_unique<PileModes>(stack, channel, nodes, asked_out, asked_in, orders, isa);
  const auto cosines = [](std::span<const AskedCosine> asked) {
    std::vector<double> mu;
    for (const AskedCosine& a : asked) mu.push_back(a.mu);
    return mu;
  };
  const DirectionSets sets(nodes, cosines(asked_out), cosines(asked_in), grazing_map(stack));
  return std::make_unique<StackModes>(stack, channel, sets, orders, isa);
}

}  // namespace lamella
