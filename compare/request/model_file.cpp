#include "compare/request/model_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "analytic/catalogue/model_plugin.h"
#include "compare/request/errors.h"

namespace lamella {
namespace {

constexpr std::streamsize kLongestFile = 1 << 16;

std::string without_blanks(const std::string& text) {
  const std::size_t from = text.find_first_not_of(" \t\r");
  if (from == std::string::npos) return {};
  return text.substr(from, text.find_last_not_of(" \t\r") - from + 1);
}

// A shared object, or the file of a key "stack", that is named relative to the file it stands in.
std::string with_files_beside(const std::string& request, const std::filesystem::path& folder) {
  if (folder.empty()) return request;
  const auto found = [&](const std::string& file) {
    return is_plugin_path(file) || file.ends_with(".toml") ? (folder / file).string() : file;
  };
  std::string text;
  for (std::size_t from = 0; from <= request.size();) {
    const std::size_t comma = std::min(request.find(',', from), request.size());
    const std::string part = request.substr(from, comma - from);
    static const std::string key = "stack=";
    if (from == 0)
      text = found(part);
    else
      text += "," + (part.starts_with(key) ? key + found(part.substr(key.size())) : part);
    from = comma + 1;
  }
  return text;
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
  return with_files_beside(request, std::filesystem::path(name).parent_path());
}

}  // namespace lamella
