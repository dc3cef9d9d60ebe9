#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <string_view>

namespace lamella {

/// SHA-256 of bytes that come piece by piece.
class ContentHash {
 public:
  ContentHash();
  ContentHash(const ContentHash&) = delete;
  ContentHash& operator=(const ContentHash&) = delete;
  ~ContentHash();
  void add(std::string_view bytes);
  /// Of all that was added, as content_hash gives it; called once.
  [[nodiscard]] std::string digits();

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

/// SHA-256 (FIPS 180-4) in lower-case hexadecimal digits, as the program sha256sum prints it.
[[nodiscard]] std::string content_hash(std::string_view bytes);

/// The hash of a file's content, or of its first `bytes`, read piece by piece. Throws OutputError
/// where it cannot be read.
[[nodiscard]] std::string content_hash_of_file(
    const std::filesystem::path& path,
    std::uintmax_t bytes = std::numeric_limits<std::uintmax_t>::max());

}  // namespace lamella
