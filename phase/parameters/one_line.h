#pragma once

#include <string>
#include <string_view>

namespace lamella {

/// Text of another library as part of an error of ours: its lines joined by one blank each, control
/// characters and bytes that are no UTF-8 as "?", cut after `most` bytes (a cut ends in "...").
[[nodiscard]] std::string one_line(std::string_view text, std::size_t most = 160);

}  // namespace lamella
