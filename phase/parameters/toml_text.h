#pragma once

// Words and keys as TOML has them, so that what a file or a message shows can be read again.

#include <string>
#include <string_view>

namespace lamella {

// A basic string in quotes: quotes, backslashes and control characters are escaped, so that it is
// always one line. `text` is UTF-8.
[[nodiscard]] std::string quoted(std::string_view text);

// A key: bare where TOML allows that, else quoted.
[[nodiscard]] std::string toml_key(std::string_view key);

}  // namespace lamella
