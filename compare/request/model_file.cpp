#include "compare/request/model_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "compare/request/errors.h"

namespace lamella {
namespace {

constexpr std::streamsize kLongestFile = 1 << 16;

std::string without_blanks(const std::string& text) {
  const std::size_t from = text.find_first_not_of(" \t\r");
  if (from == std::string::npos) return {};
  return text.substr(from, text.find_last_not_of(" \t\r") - from + 1);
}

}  // namespace

std::string model_text(const std::string& text) {
  if (!text.starts_with('@')) return text;
  const std::string name = text.substr(1);
  std::ifstream file(name, std::ios::binary);
  const bool folder = std::filesystem::is_directory(name);
  if (!file || folder)
    throw UsageError(fmt::format("{}: {}; allowed: a file with a model in it, as fit -o writes it",
                                 name, std::strerror(folder ? EISDIR : errno)));
  std::string content(kLongestFile + 1, '\0');
  file.read(content.data(), kLongestFile + 1);
  if (file.gcount() > kLongestFile)
    throw UsageError(fmt::format(
        "{}: found more than {} bytes; allowed: one line, NAME,key=value,...", name, kLongestFile));
  content.resize(static_cast<std::size_t>(file.gcount()));
  std::string request;
  int line = 1;
  for (std::size_t from = 0; from <= content.size(); ++line) {
    const std::size_t end = std::min(content.find('\n', from), content.size());
    const std::string part = without_blanks(content.substr(from, end - from));
    from = end + 1;
    if (part.empty() || part.starts_with('#')) continue;
    if (!request.empty())
      throw UsageError(
          fmt::format("{}:{}: found a second model; allowed: one per file", name, line));
    request = part;
  }
  if (request.empty())
    throw UsageError(fmt::format("{}:1: found no model; allowed: NAME,key=value,...", name));
  return request;
}

}  // namespace lamella
