#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>

namespace lamella {

/// SHA-256 (FIPS 180-4) in lower-case hexadecimal digits, as the program sha256sum prints it.
[[nodiscard]] std::string content_hash(std::string_view bytes);

/// The hash of a file's content, or of its first `bytes`, read piece by piece. Throws OutputError
/// where it cannot be read.
[[nodiscard]] std::string content_hash_of_file(
    const std::filesystem::path& path,
    std::uintmax_t bytes = std::numeric_limits<std::uintmax_t>::max());

}  // namespace lamella
