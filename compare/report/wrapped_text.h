#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace lamella {

/// Columns of a terminal that the program's tables and texts keep to where they can.
inline constexpr std::size_t kTerminalWidth = 100;

/// A paragraph broken at blanks into lines of at most kTerminalWidth columns. The first line begins
/// with `first`, the others with as many blanks as `first` has columns, or with `indent` blanks. A
/// word that is longer stays whole.
[[nodiscard]] std::string wrapped(std::string_view first, std::string_view text);
[[nodiscard]] std::string wrapped(std::string_view first, std::string_view text,
                                  std::size_t indent);

}  // namespace lamella
