#pragma once

#include <string>
#include <string_view>

#include "phase/stack/stack.h"
#include "phase/stack/stack_file_error.h"

namespace lamella {

/// Reads a stack from TOML text (phase/README.md has the format). `file` is the name used in
/// errors; names of grids are relative to its folder. `name` becomes Stack::name. Throws
/// StackFileError.
[[nodiscard]] Stack parse_stack(std::string_view text, const std::string& file, std::string name);

/// The stack as TOML text with every default filled in; parse_stack reads it back the same.
[[nodiscard]] std::string to_toml(const Stack& stack);

}  // namespace lamella
