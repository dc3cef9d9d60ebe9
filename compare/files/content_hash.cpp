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

void require(bool done) {
  if (!done) throw std::runtime_error("SHA-256: libcrypto does not provide it");
}

}  // namespace

struct ContentHash::Context {
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> of{EVP_MD_CTX_new(), &EVP_MD_CTX_free};
};

ContentHash::ContentHash() : context_(std::make_unique<Context>()) {
  require(context_->of && EVP_DigestInit_ex(context_->of.get(), EVP_sha256(), nullptr));
}

ContentHash::~ContentHash() = default;

void ContentHash::add(std::string_view bytes) {
  require(EVP_DigestUpdate(context_->of.get(), bytes.data(), bytes.size()));
}

std::string ContentHash::digits() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  require(EVP_DigestFinal_ex(context_->of.get(), digest.data(), &size));
  std::string text;
  for (unsigned k = 0; k < size; ++k) text += fmt::format("{:02x}", digest.at(k));
  return text;
}

std::string content_hash(std::string_view bytes) {
  ContentHash hash;
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
  ContentHash hash;
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
