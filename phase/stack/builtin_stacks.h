#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "phase/stack/stack.h"

namespace lamella {

/// A stack that Lamella knows by name: a configuration of one of the papers, or a standard case.
struct BuiltinStack {
  std::string name;
  std::string doc;     ///< what it is, and which of its numbers are Lamella's own choice
  std::string source;  ///< where the numbers come from
  std::string toml;
};

[[nodiscard]] const std::vector<BuiltinStack>& builtin_stacks();

/// What runs when no stack is given.
inline constexpr std::string_view kDefaultStack = "spongecake_two_layer";

/// A stack by the name of a built-in one, by the path of a TOML file, or "-" for stdin. A built-in
/// name wins over a file; write ./name for the file. Throws StackFileError.
[[nodiscard]] Stack load_stack(const std::string& what);

}  // namespace lamella
