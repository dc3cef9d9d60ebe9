#pragma once

#include <memory>
#include <optional>
#include <span>

#include "volume/adding/stack_solver.h"

namespace lamella {

/// The stack with only those events that SecondOrder counts: other layers and the substrate absorb.
[[nodiscard]] Stack counted_by_second_order(const Stack& stack);

/// Splits order 2 of a stack's modes into what SecondOrder counts and the rest. Parameters as in
/// make_stack_solver.
class SecondSplit {
 public:
  SecondSplit(const Stack& stack, int channel, int nodes, std::span<const AskedCosine> asked_out,
              std::span<const AskedCosine> asked_in, Isa isa);
  SecondSplit(const SecondSplit&) = delete;
  SecondSplit& operator=(const SecondSplit&) = delete;
  /// The counted part of order 2 between directions that were asked for, if it is not all.
  [[nodiscard]] std::optional<Parts> counted(int m);

 private:
  Stack stack_;
  bool every_mode_, first_mode_;
  std::unique_ptr<StackSolver> modes_;  // of stack_
};

}  // namespace lamella
