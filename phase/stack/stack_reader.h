#pragma once

#include <string>

#include "phase/stack/stack.h"
#include "phase/stack/toml_library.h"

namespace lamella {

/// Parses TOML. Throws StackFileError with file and line.
[[nodiscard]] toml::table parse_toml(std::string_view text, const std::string& file);

/// The stack of a file's tables, in which no value is a picture. Throws StackFileError.
[[nodiscard]] Stack read_stack(const toml::table& root, const std::string& file, std::string name);

}  // namespace lamella
