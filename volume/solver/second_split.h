#pragma once

#include <optional>

#include "volume/adding/stack_modes.h"

namespace lamella {

/// The stack with only those events that SecondOrder counts: other layers and the substrate absorb.
[[nodiscard]] Stack counted_by_second_order(const Stack& stack);

/// Splits order 2 of a stack's modes into what SecondOrder counts and the rest.
class SecondSplit {
 public:
  SecondSplit(const Stack& stack, int channel, const DirectionSets& sets, Isa isa);
  /// The counted part of order 2 between directions that were asked for, if it is not all.
  [[nodiscard]] std::optional<Parts> counted(int m);

 private:
  Stack stack_;
  bool every_mode_, first_mode_;
  std::optional<StackModes> modes_;
};

}  // namespace lamella
