#pragma once

#include <string>

namespace lamella {

/// A model as --model takes it: the text itself, or for @FILE the text in the file. A file holds
/// one request, NAME,key=value,..., as `lamella fit -o` writes it; empty lines and those that begin
/// with # are left out; shared objects and stack files are named relative to it. Throws UsageError
/// with the file's name and line.
[[nodiscard]] std::string model_text(const std::string& text);

}  // namespace lamella
