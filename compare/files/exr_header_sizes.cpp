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

// Types that the library reads by their own length, whatever size stands before them.
struct FixedType {
  const char* name;
  std::uint32_t size;
};
constexpr FixedType kFixed[] = {{"int", 4},
                                {"float", 4},
                                {"double", 8},
                                {"box2i", 16},
                                {"box2f", 16},
                                {"v2i", 8},
                                {"v2f", 8},
                                {"v2d", 16},
                                {"v3i", 12},
                                {"v3f", 12},
                                {"v3d", 24},
                                {"m33f", 36},
                                {"m33d", 72},
                                {"m44f", 64},
                                {"m44d", 128},
                                {"envmap", 1},
                                {"lineOrder", 1},
                                {"keycode", 28},
                                {"chromaticities", 32},
                                {"tiledesc", 9},
                                {"rational", 8},
                                {"timecode", 8},
                                {"compression", 1},
                                {"deepImageState", 1}};

// How many bytes of the content the library reads for that type; nothing where it goes by the size.
std::optional<std::uintmax_t> length_of(std::istream& in, const std::string& type) {
  for (const FixedType& fixed : kFixed)
    if (type == fixed.name) return fixed.size;
  const auto from = in.tellg();
  std::optional<std::uintmax_t> length;
  if (type == "preview") {
    const auto width = read_word(in), height = read_word(in);
    if (width && height) length = 8 + std::uintmax_t{4} * *width * *height;
  } else if (type == "chlist") {  // names, each with 16 bytes, up to an empty one
    for (auto name = read_name(in); name; name = read_name(in)) {
      if (name->empty()) {
        length = static_cast<std::uintmax_t>(in.tellg() - from);
        break;
      }
      in.seekg(16, std::ios::cur);
    }
    if (!length) length = 0;
  }
  in.clear();
  in.seekg(from);
  return length;
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
      if (const auto length = length_of(in, *type); length && *length != *bytes)
        throw std::runtime_error(
            fmt::format("an attribute of the type {} with {} bytes, where its "
                        "content has {}",
                        *type, *bytes, *length));
      in.seekg(*bytes, std::ios::cur);
    }
    if (!name || !(*version & kMultiPart)) return;
  }
}

}  // namespace lamella
