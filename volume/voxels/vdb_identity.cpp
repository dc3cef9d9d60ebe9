#include "volume/voxels/vdb_identity.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <vector>

namespace lamella {
namespace {

// Magic number (8 bytes), file version (4), the library's major and minor version (4, 4), whether
// grids have offsets (1).
constexpr std::streamoff kIdentityAt = 21;
constexpr std::size_t kIdentityLength = 36;

bool is_identity(const std::array<char, kIdentityLength>& text) {
  for (std::size_t k = 0; k < text.size(); ++k) {
    const bool dash = k == 8 || k == 13 || k == 18 || k == 23;
    if (dash ? text[k] != '-' : !std::isxdigit(static_cast<unsigned char>(text[k]))) return false;
  }
  return true;
}

// Fowler, Noll and Vo's hash (FNV-1a) of 64 bits, twice, from different starts: no defence against
// anybody, but different grids do not meet by accident.
struct Digest {
  std::uint64_t a = 0xcbf29ce484222325, b = 0x84222325cbf29ce4;
  void add(unsigned char byte) {
    constexpr std::uint64_t kPrime = 0x100000001b3;
    a = (a ^ byte) * kPrime;
    b = (b ^ (byte + 0x5bU)) * kPrime;
  }
  [[nodiscard]] std::string text() const {
    const std::string hex = fmt::format("{:016x}{:016x}", a, b);
    return hex.substr(0, 8) + '-' + hex.substr(8, 4) + '-' + hex.substr(12, 4) + '-' +
           hex.substr(16, 4) + '-' + hex.substr(20);
  }
};

}  // namespace

void set_identity_by_content(const std::string& path) {
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  std::array<char, kIdentityLength> identity{};
  file.seekg(kIdentityAt);
  file.read(identity.data(), identity.size());
  // A later version of the library may have it elsewhere: then the file stays as it is.
  if (!file || !is_identity(identity)) return;
  Digest digest;
  std::vector<char> block(1 << 16);
  file.seekg(kIdentityAt + static_cast<std::streamoff>(kIdentityLength));
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())), file.gcount() > 0)
    for (std::streamsize k = 0; k < file.gcount(); ++k)
      digest.add(static_cast<unsigned char>(block[k]));
  file.clear();
  file.seekp(kIdentityAt);
  file << digest.text() << std::flush;
  if (!file) throw std::runtime_error("its identifier cannot be written");
}

}  // namespace lamella
