#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace lamella {

/// A number as people type it, "inf" among them; nothing if the text is anything else.
[[nodiscard]] std::optional<double> parse_number(std::string_view text);

/// A whole number, written in digits or like 1e6.
[[nodiscard]] std::optional<std::uint64_t> parse_whole_number(std::string_view text);

}  // namespace lamella
