#pragma once

#include <memory>
#include <span>

#include "volume/adding/stack_solver.h"

namespace lamella {

/// The solver for a stack: StackModes, or PileModes where there are boundaries. Cosines as in
/// AskedCosine; orders: how many of the orders 1 to 3 to keep apart; isa: of
/// products of matrices. The stack must outlive it.
[[nodiscard]] std::unique_ptr<StackSolver> make_stack_solver(const Stack& stack, int channel,
                                                             int nodes,
                                                             std::span<const AskedCosine> asked_out,
                                                             std::span<const AskedCosine> asked_in,
                                                             int orders, Isa isa);

}  // namespace lamella
