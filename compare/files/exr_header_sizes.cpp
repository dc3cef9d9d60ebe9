#include "compare/files/exr_header_sizes.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>

namespace lamella {
namespace {

// "OpenEXR File Layout": a magic number, a version with flags, then headers; each is a list of
// attributes, name, type, size and content, and ends with an empty name. Of several parts the list
// of headers ends with an empty one.
constexpr std::uint32_t kMagic = 20000630, kMultiPart = 0x1000;
constexpr std::size_t kLongestName = 255;

std::optional<std::uint32_t> read_word(std::istream& in) {
  std::array<unsigned char, 4> bytes{};
  if (!in.read(reinterpret_cast<char*>(bytes.data()), 4)) return std::nullopt;
  std::uint32_t word = 0;
  for (int k = 3; k >= 0; --k) word = word << 8 | bytes[static_cast<std::size_t>(k)];
  return word;
}

// Up to a null, or nothing where there is none within reach.
std::optional<std::string> read_name(std::istream& in) {
  std::string name;
  for (int c = 0; (c = in.get()) > 0;) {
    if (name.size() == kLongestName) return std::nullopt;
    name += static_cast<char>(c);
  }
  return in ? std::optional(name) : std::nullopt;
}

}  // namespace

void check_exr_header_sizes(const std::filesystem::path& path) {
  std::error_code unknown;
  const std::uintmax_t size = std::filesystem::file_size(path, unknown);
  if (unknown) return;  // a pipe
  std::ifstream in(path, std::ios::binary);
  const auto magic = read_word(in), version = read_word(in);
  if (magic != kMagic || !version) return;
  for (bool is_first = true;; is_first = false) {
    auto name = read_name(in);
    // An empty header.
    if (!name || (name->empty() && !is_first)) return;
    for (; name && !name->empty(); name = read_name(in)) {
      const auto type = read_name(in);
      const auto bytes = read_word(in);
      if (!type || !bytes) return;
      const auto at = static_cast<std::uintmax_t>(in.tellg());
      if (*bytes > size - at)
        throw std::runtime_error(
            fmt::format("an attribute of {} bytes, where the file has {} left", *bytes, size - at));
      in.seekg(*bytes, std::ios::cur);
    }
    if (!name || !(*version & kMultiPart)) return;
  }
}

}  // namespace lamella
