#pragma once

#include <string>
#include <string_view>

namespace lamella {

/// UTF-8 that a drawing library takes: bytes that are none become U+FFFD, control characters
/// blanks.
[[nodiscard]] std::string printable_text(std::string_view utf8);

}  // namespace lamella
