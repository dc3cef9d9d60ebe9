#include "compare/files/content_hash.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <system_error>

#include "compare/files/output_folder.h"

namespace lamella {
namespace {

class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), &EVP_MD_CTX_free) {
    require(context_ && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr));
  }
  void add(std::string_view bytes) {
    require(EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()));
  }
  [[nodiscard]] std::string digits() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned size = 0;
    require(EVP_DigestFinal_ex(context_.get(), digest.data(), &size));
    std::string text;
    for (unsigned k = 0; k < size; ++k) text += fmt::format("{:02x}", digest.at(k));
    return text;
  }

 private:
  static void require(bool done) {
    if (!done) throw std::runtime_error("SHA-256: libcrypto does not provide it");
  }

  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

}  // namespace

std::string content_hash(std::string_view bytes) {
  Sha256 hash;
  hash.add(bytes);
  return hash.digits();
}

std::string content_hash_of_file(const std::filesystem::path& path, std::uintmax_t bytes) {
  const auto fail = [&](const std::string& reason) {
    throw OutputError(fmt::format("cannot read {}: {}", path.string(), reason));
  };
  std::error_code error;
  // A pipe or device has no content that stays.
  const auto status = std::filesystem::status(path, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    fail("it is no regular file");
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(std::generic_category().message(errno));
  Sha256 hash;
  std::array<char, 1 << 16> piece{};
  while (bytes > 0 && (file.read(piece.data(), piece.size()) || file.gcount() > 0)) {
    const auto count = std::min(static_cast<std::uintmax_t>(file.gcount()), bytes);
    hash.add({piece.data(), static_cast<std::size_t>(count)});
    bytes -= count;
  }
  if (file.bad()) fail(std::generic_category().message(errno));
  return hash.digits();
}

}  // namespace lamella
