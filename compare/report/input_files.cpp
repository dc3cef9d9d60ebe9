#include "compare/report/input_files.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <optional>
#include <sstream>
#include <system_error>

#include "compare/files/content_hash.h"
#include "compare/files/output_folder.h"
#include "phase/stack/stack_file.h"
#include "phase/stack/stack_paths.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

// What changes with a file's content, unless somebody sets the clock back.
std::string stamp_of(const fs::path& path) {
  struct stat s {};
  if (::stat(path.c_str(), &s) != 0) return "";
  return fmt::format("{} {} {} {}.{} {}.{}", s.st_dev, s.st_ino, s.st_size, s.st_mtim.tv_sec,
                     s.st_mtim.tv_nsec, s.st_ctim.tv_sec, s.st_ctim.tv_nsec);
}

std::optional<std::string> recorded_hash(const std::string& name, const std::string& recorded) {
  std::istringstream lines(recorded);
  for (std::string line; std::getline(lines, line);)
    if (const std::size_t gap = line.find("  ");
        gap != std::string::npos && line.substr(gap + 2) == name)
      return line.substr(0, gap);
  return std::nullopt;
}

}  // namespace

InputFiles::InputFiles(const Stack& stack, const std::vector<fs::path>& models) {
  std::vector<fs::path> paths = files_of(stack);
  paths.insert(paths.end(), models.begin(), models.end());
  for (const fs::path& path : paths) {
    const bool known = std::any_of(files_.begin(), files_.end(),
                                   [&](const File& file) { return file.path == path; });
    if (known || !fs::is_regular_file(path)) continue;
    std::string stamp = stamp_of(path);
    files_.push_back({path, content_hash_of_file(path), std::move(stamp)});
  }
}

void InputFiles::check() const {
  for (const File& file : files_) {
    if (!file.stamp.empty() && stamp_of(file.path) == file.stamp) continue;
    if (content_hash_of_file(file.path) != file.hash)
      throw OutputError(
          fmt::format("{}: found another content than when the run began; allowed: input files "
                      "that stay as they are until it ends",
                      file.path.string()));
  }
}

std::string InputFiles::text(const fs::path& folder) const {
  std::string text;
  for (const File& file : files_)
    text += fmt::format("{}  {}\n", file.hash, relative_to(file.path, folder).string());
  return text;
}

nlohmann::ordered_json InputFiles::json(const fs::path& folder) const {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const File& file : files_)
    list.push_back({{"name", relative_to(file.path, folder).string()}, {"sha256", file.hash}});
  return list;
}

fs::path find_recorded(const std::string& name, const std::string& recorded, const fs::path& folder,
                       const std::string& where) {
  const fs::path named = folder / name, beside = folder / named.filename();
  const std::optional<std::string> hash = recorded_hash(name, recorded);
  if (!hash) return named;
  std::string other;
  for (const fs::path& path : {named, beside}) {
    if (!fs::exists(path)) continue;
    const std::string found = content_hash_of_file(path);
    if (found == *hash) return path;
    if (other.empty()) other = fmt::format("{} of sha256 {}", path.string(), found);
  }
  throw StackFileError(
      fmt::format("{}: file \"{}\": found {}; allowed: the file that was read, of sha256 {}, there "
                  "or beside {}",
                  where, name, other.empty() ? "nothing" : other, *hash, where));
}

Stack with_found_files(Stack stack, const std::string& recorded, const fs::path& folder,
                       const std::string& where) {
  for (Layer& layer : stack.layers)
    if (layer.grid && is_file(*layer.grid)) {
      const fs::path found = find_recorded(layer.grid->file, recorded, folder, where);
      layer.grid->folder = found.parent_path().string();
      layer.grid->file = found.filename().string();
    }
  return stack;
}

}  // namespace lamella
