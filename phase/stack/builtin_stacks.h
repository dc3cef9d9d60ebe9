#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "phase/stack/builtin_stack.h"
#include "phase/stack/mapped_stack.h"
#include "phase/stack/stack.h"

namespace lamella {

[[nodiscard]] const std::vector<BuiltinStack>& builtin_stacks();

/// What runs when no stack is given.
inline constexpr std::string_view kDefaultStack = "spongecake_two_layer";

/// A stack by the name of a built-in one, by the path of a TOML file, or "-" for stdin. A built-in
/// name wins over a file; write ./name for the file. Throws StackFileError, also where a picture is
/// among the stack's values.
[[nodiscard]] Stack load_stack(const std::string& what);
/// The same of a stack with pictures among its values, or without.
[[nodiscard]] MappedStack load_mapped_stack(const std::string& what);

}  // namespace lamella
