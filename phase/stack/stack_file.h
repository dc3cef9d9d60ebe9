#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "phase/stack/stack.h"

namespace lamella {

/// A stack file that is refused. what() names file, line, key, the value found and the values
/// allowed.
struct StackFileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Reads a stack from TOML text (phase/README.md has the format). `file` is the name used in
/// errors; names of grids are relative to its folder. `name` becomes Stack::name. Throws
/// StackFileError.
[[nodiscard]] Stack parse_stack(std::string_view text, const std::string& file, std::string name);

/// The stack as TOML text with every default filled in; parse_stack reads it back the same.
[[nodiscard]] std::string to_toml(const Stack& stack);

}  // namespace lamella
