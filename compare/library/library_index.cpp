#include "compare/library/library_index.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <set>

#include "compare/exchange/tensor_container.h"
#include "compare/files/content_hash.h"
#include "compare/request/errors.h"
#include "compare/request/substrate_model.h"
#include "phase/parameters/parameters.h"
#include "phase/stack/stack_file.h"
#include "phase/stack/text_file.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr int kFormat = 1;
constexpr int kMostDepth = 8;
constexpr std::size_t kMostIndexBytes = std::size_t{64} << 20;
constexpr std::uint64_t kMostEntryBytes = std::uint64_t{256} << 20;

Json method_json(const ReferenceMethod& method) {
  Json json{{"method", method.name}};
  if (!method.reason.empty()) json["reason"] = method.reason;
  if (method.is_bounded()) {
    json["tolerance"] = method.tolerance;
    json["reached"] = method.reached();
    json["bound"] = method.error;
  } else {
    json["walks"] = method.walks;
    json["relative_standard_error"] = method.error;
  }
  return json;
}

Json entry_json(const LibraryEntry& entry) {
  Json files = Json::array();
  for (const EntryFile& file : entry.files)
    files.push_back({{"name", file.name}, {"bytes", file.bytes}, {"sha256", file.sha256}});
  Json points = method_json(entry.points);
  points["count"] = entry.pairs;
  return {{"name", entry.name},         {"group", entry.group},
          {"about", entry.about},       {"source", entry.source},
          {"stack", entry.stack},       {"version", entry.version},
          {"channels", entry.channels}, {"grid", entry.grid},
          {"seed", entry.seed},         {"lobes", method_json(entry.lobes)},
          {"points", points},           {"seconds", entry.seconds},
          {"files", std::move(files)}};
}

// Members of the index, each of its type.
class IndexReader {
 public:
  IndexReader(const Json& json, std::string where) : json_(json), where_(std::move(where)) {}

  [[noreturn]] void refuse(const char* key, const std::string& allowed) const {
    throw UsageError(
        fmt::format("{}: \"{}\": found {}; allowed: {}", where_, key,
                    json_.is_object() && json_.contains(key)
                        ? json_[key].dump(-1, ' ', false, Json::error_handler_t::replace)
                        : "nothing",
                    allowed));
  }
  [[nodiscard]] const Json& at(const char* key) const {
    if (!json_.is_object() || !json_.contains(key)) refuse(key, "what lamella library writes");
    return json_[key];
  }
  [[nodiscard]] std::string text(const char* key) const {
    const Json& value = at(key);
    if (!value.is_string()) refuse(key, "a text");
    return value.get<std::string>();
  }
  [[nodiscard]] std::uint64_t whole(const char* key) const {
    const Json& value = at(key);
    if (!value.is_number_unsigned()) refuse(key, "a whole number");
    return value.get<std::uint64_t>();
  }
  [[nodiscard]] double number(const char* key) const {
    const Json& value = at(key);
    // JSON has no infinity.
    if (value.is_null()) return std::numeric_limits<double>::infinity();
    if (!value.is_number()) refuse(key, "a number");
    return value.get<double>();
  }
  [[nodiscard]] IndexReader inside(const char* key) const {
    const Json& value = at(key);
    if (!value.is_object()) refuse(key, "an object");
    return {value, fmt::format("{}: \"{}\"", where_, key)};
  }
  [[nodiscard]] bool has(const char* key) const { return json_.is_object() && json_.contains(key); }

 private:
  const Json& json_;
  std::string where_;
};

ReferenceMethod method_of(const IndexReader& in) {
  ReferenceMethod method{.name = in.text("method")};
  if (in.has("reason")) method.reason = in.text("reason");
  if (in.has("walks")) {
    method.walks = in.whole("walks");
    if (method.walks == 0) in.refuse("walks", "a whole number from 1");
    method.error = in.number("relative_standard_error");
  } else {
    method.tolerance = in.number("tolerance");
    method.error = in.number("bound");
  }
  return method;
}

bool is_entry_name(const std::string& name) {
  return !name.empty() && name[0] != '.' && name.size() <= 100 &&
         name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_.-") == std::string::npos;
}

LibraryEntry entry_of(const Json& json, const std::string& where) {
  const IndexReader in(json, where);
  LibraryEntry entry{.name = in.text("name"),
                     .group = in.text("group"),
                     .about = in.text("about"),
                     .source = in.text("source"),
                     .stack = in.text("stack"),
                     .version = in.text("version"),
                     .channels = static_cast<int>(in.whole("channels")),
                     .grid = in.text("grid"),
                     .seed = in.whole("seed"),
                     .lobes = method_of(in.inside("lobes")),
                     .points = method_of(in.inside("points")),
                     .pairs = in.inside("points").whole("count"),
                     .seconds = in.number("seconds")};
  if (!is_entry_name(entry.name)) in.refuse("name", "letters a-z, digits, _, . and -");
  if (!in.at("files").is_array()) in.refuse("files", "a list");
  for (const Json& file : in.at("files")) {
    const IndexReader of(file, where + ": \"files\"");
    entry.files.push_back({of.text("name"), of.whole("bytes"), of.text("sha256")});
    if (!is_entry_name(entry.files.back().name))
      of.refuse("name", "a name of a file of the folder");
  }
  return entry;
}

const EntryFile& archive_of(const LibraryEntry& entry, const fs::path& folder) {
  const auto found = std::find_if(entry.files.begin(), entry.files.end(),
                                  [](const EntryFile& f) { return f.name.ends_with(".npz"); });
  if (found == entry.files.end())
    throw UsageError(
        fmt::format("{}: found no .npz of \"{}\"; allowed: entries as lamella library "
                    "build writes them",
                    (folder / kIndexName).string(), entry.name));
  return *found;
}

}  // namespace

const LibraryEntry* LibraryIndex::find(const std::string& name) const {
  const auto found = std::find_if(entries.begin(), entries.end(),
                                  [&](const LibraryEntry& e) { return e.name == name; });
  return found == entries.end() ? nullptr : &*found;
}

LibraryIndex read_index(const fs::path& folder) {
  const fs::path file = folder / kIndexName;
  std::string text;
  try {
    text = read_text_file(file.string(), kMostIndexBytes);
  } catch (const TextFileError& error) {
    throw UsageError(fmt::format("{}: {}; allowed: a folder of lamella library build",
                                 file.string(), error.what()));
  }
  return index_from(text, file.string());
}

LibraryIndex index_from(const std::string& text, const std::string& file) {
  // Deeper than what is written: whatever prints it would need as deep a stack.
  bool deep = false;
  const auto shallow = [&](int depth, Json::parse_event_t, Json&) {
    deep = deep || depth > kMostDepth;
    return !deep;
  };
  const Json parsed = Json::parse(text, shallow, false), json = deep ? Json() : parsed;
  const auto format = json.is_object() ? json.find("format") : json.end();
  if (!json.is_object() || format == json.end() || *format != Json(kFormat) ||
      !json.contains("entries") || !json["entries"].is_array())
    throw UsageError(
        fmt::format("{}: found no index of format {}; allowed: a folder of lamella library build",
                    file, kFormat));
  LibraryIndex index;
  std::set<std::string> names;
  for (const Json& entry : json["entries"]) {
    index.entries.push_back(
        entry_of(entry, fmt::format("{}: entry {}", file, index.entries.size())));
    if (!names.insert(index.entries.back().name).second)
      throw UsageError(fmt::format("{}: found \"{}\" twice; allowed: each name once", file,
                                   index.entries.back().name));
  }
  return index;
}

std::string to_text(const LibraryIndex& index) {
  Json entries = Json::array();
  for (const LibraryEntry& entry : index.entries) entries.push_back(entry_json(entry));
  return Json{{"format", kFormat}, {"program", "lamella"}, {"entries", std::move(entries)}}.dump(
             1) +
         "\n";
}

std::optional<std::string> why_not_whole(const LibraryEntry& entry, const fs::path& folder) {
  if (entry.files.empty()) return "it has no files";
  for (const EntryFile& file : entry.files) {
    const fs::path path = folder / file.name;
    std::error_code error;
    const std::uintmax_t size = fs::file_size(path, error);
    if (error) return fmt::format("{}: {}", file.name, error.message());
    if (size != file.bytes) return fmt::format("{}: {} bytes for {}", file.name, size, file.bytes);
    if (content_hash_of_file(path) != file.sha256)
      return fmt::format("{}: another content than its SHA-256 says", file.name);
  }
  return std::nullopt;
}

Reference read_reference(const LibraryEntry& entry, const fs::path& folder) {
  const EntryFile& file = archive_of(entry, folder);
  const fs::path path = folder / file.name;
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  const auto refuse = [&](const std::string& what) {
    throw UsageError(
        fmt::format("{}: {}; allowed: the file that index.json tells (lamella library "
                    "build makes it again)",
                    path.string(), what));
  };
  if (error) refuse(error.message());
  if (size != file.bytes || size > kMostEntryBytes)
    refuse(fmt::format("found {} bytes in the place of {}", size, file.bytes));
  std::string bytes(size, '\0');
  std::ifstream in(path, std::ios::binary);
  if (!in.read(bytes.data(), static_cast<std::streamsize>(size))) refuse("cannot be read");
  if (content_hash(bytes) != file.sha256) refuse("found another content than its SHA-256 says");
  try {
    Reference reference = reference_of_npz(bytes, path.string());
    if (reference.set.channels != entry.channels || reference.pairs.size() != entry.pairs)
      refuse("found other channels or points than index.json tells");
    reference.lobe_method = entry.lobes;
    reference.point_method = entry.points;
    return reference;
  } catch (const FormatError& damage) {
    throw UsageError(damage.what());
  }
}

Stack stack_of_entry(const LibraryEntry& entry) {
  return with_surface_model(
      parse_stack(entry.stack, fmt::format("index.json, stack of {}", entry.name), entry.name));
}

void check_names(const std::vector<std::string>& names, const std::vector<std::string>& allowed,
                 const std::string& option) {
  for (const std::string& name : names) {
    if (std::find(allowed.begin(), allowed.end(), name) != allowed.end()) continue;
    const std::string hint = suggestion(name, allowed);
    throw UsageError(
        fmt::format("{}: found \"{}\"; allowed: an entry that lamella library show "
                    "lists{}",
                    option, name, hint.empty() ? "" : "; " + hint));
  }
}

}  // namespace lamella
