#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace lamella {

/// Why a file cannot be read: "No such file or directory", "is a directory", ...
struct TextFileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The bytes of a file, at most `most`; "-" for stdin. A pipe (as a shell makes of <(command)) is
/// read like a file, but only waited for, without anybody who writes, for `seconds`. A device has
/// no end and is refused; so is a file with more bytes than `most`. Throws TextFileError.
[[nodiscard]] std::string read_text_file(const std::string& path, std::size_t most,
                                         double seconds = 10);

}  // namespace lamella
