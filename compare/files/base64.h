#pragma once

#include <string>
#include <string_view>

namespace lamella {

/// Bytes as text of the alphabet A-Z a-z 0-9 + /, with = at its end (RFC 4648).
[[nodiscard]] std::string base64(std::string_view bytes);

}  // namespace lamella
