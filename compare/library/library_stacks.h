#pragma once

#include <string>
#include <vector>

#include "phase/stack/stack.h"

namespace lamella {

/// A stack of the library of reference lobes.
struct LibraryStack {
  std::string name;   ///< of the entry and its files: [a-z0-9_.]+
  std::string group;  ///< "paper", "coat", "plate", "problem" or "hard"
  std::string about;  ///< what it is
  std::string source;
  Stack stack{};
};

/// The stacks of the library, in its order: built-in ones, and those that the library adds. Each
/// name is there once.
[[nodiscard]] std::vector<LibraryStack> library_stacks();

/// The incident directions of an entry: 8, from above, of a stack that is open below also from
/// there. Azimuths differ where the stack is not symmetric about the normal.
[[nodiscard]] std::vector<Direction> library_directions(const Stack& stack);

}  // namespace lamella
