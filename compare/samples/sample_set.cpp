#include "compare/samples/sample_set.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <fstream>
#include <optional>
#include <utility>

#include "compare/files/content_hash.h"
#include "compare/files/folder_lock.h"
#include "compare/files/open_file.h"
#include "compare/files/output_folder.h"
#include "compare/request/errors.h"
#include "compare/shards/merged_keeper.h"

namespace lamella {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// A file that lines are added to, each of them on the disk before the next.
class LineFile {
 public:
  explicit LineFile(fs::path path)
      : path_(std::move(path)),
        file_(::open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666), {}) {
    if (file_.descriptor() < 0) fail_at("write", path_, last_system_error());
  }
  // A line that a crash cut off must not swallow the next one.
  void add(const std::string& line) {
    if (const auto error = file_.write(line + "\n")) fail_at("write", path_, error);
    if (const auto error = file_.sync()) fail_at("write", path_, error);
  }

 private:
  fs::path path_;
  OpenFile file_;
};

namespace {

std::string lines_name(Shard part) {
  return fmt::format("done-{}-of-{}.jsonl", part.index, part.count);
}

std::optional<Json> json_in(const fs::path& path) {
  std::ifstream in(path);
  if (!in) return std::nullopt;
  Json value = Json::parse(in, nullptr, false);
  if (value.is_discarded())
    throw UsageError(fmt::format(
        "{}: found a damaged file; allowed: one that lamella samples wrote", path.string()));
  return value;
}

}  // namespace

SampleSet::SampleSet(fs::path folder, const Json& settings, std::vector<DesignedStack> stacks,
                     Shard part)
    : folder_(std::move(folder)),
      stacks_(std::move(stacks)),
      part_(part),
      entries_(stacks_.size()) {
  make_output_folder(folder_);
  const fs::path file = folder_ / "settings.json";
  if (const auto found = json_in(file); found && *found != settings)
    throw UsageError(fmt::format("{}: found another set: {}; allowed: -o with a folder of its own",
                                 file.string(), difference_of_settings(*found, settings)));
  else if (!found)
    write_file(file, settings.dump(2) + "\n");
  read_lines();
}

void SampleSet::read_lines() {
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("done-") || !name.ends_with(".jsonl")) continue;
    std::ifstream in(entry.path());
    for (std::string line; std::getline(in, line);) {
      // The last line of a process that was killed may be cut off: its file is made again.
      Json one = Json::parse(line, nullptr, false);
      if (!one.is_object() || !one.value("number", Json()).is_number_unsigned()) continue;
      const auto k = one["number"].get<std::uint64_t>();
      if (k >= stacks_.size() || one.value("name", "") != stacks_[k].name) continue;
      const fs::path file = folder_ / one.value("file", "");
      std::error_code error;
      if (fs::file_size(file, error) != one.value("bytes", std::uintmax_t{0}) || error) continue;
      entries_[k] = std::move(one);
    }
  }
}

SampleSet::~SampleSet() = default;

void SampleSet::begin_lines() {
  if (lines_) return;
  const fs::path path = folder_ / lines_name(part_);
  lock_ = std::make_unique<FileLock>(path);
  lines_ = std::make_unique<LineFile>(path);
  // Ends what a crash cut off.
  if (fs::file_size(path) > 0) lines_->add("");
}

void SampleSet::make(const std::function<MadeFile(std::size_t, const fs::path&)>& make,
                     const std::function<void(std::size_t, const Json&, bool)>& tell,
                     const std::function<bool()>& stop) {
  begin_lines();
  for (std::size_t k = 0; k < stacks_.size() && !stop(); ++k) {
    if (!part_.has(k)) continue;
    if (!entries_[k].is_null()) {
      tell(k, entries_[k], true);
      continue;
    }
    const MadeFile made = make(k, folder_ / set_file_name(stacks_[k]));
    if (!made.whole) break;
    keep(k, set_entry(folder_, k, stacks_[k], made));
    tell(k, entries_[k], false);
  }
  lines_.reset();
  lock_.reset();
}

std::vector<std::uint64_t> SampleSet::missing() const {
  std::vector<std::uint64_t> list;
  for (std::uint64_t k = 0; k < stacks_.size(); ++k)
    if (part_.has(k) && entries_[k].is_null()) list.push_back(k);
  return list;
}

void SampleSet::keep(std::uint64_t k, Json entry) {
  const fs::path file = folder_ / set_file_name(stacks_.at(k));
  std::error_code error;
  if (fs::file_size(file, error) != entry.value("bytes", std::uintmax_t{0}) || error)
    throw UsageError(
        fmt::format("{}: found another file than that which was made; allowed: a folder that all "
                    "processes share",
                    file.string()));
  begin_lines();
  lines_->add(entry.dump());
  entries_[k] = std::move(entry);
}

std::string set_file_name(const DesignedStack& stack) { return stack.name + ".npz"; }

Json set_entry(const fs::path& folder, std::uint64_t k, const DesignedStack& stack,
               const MadeFile& made) {
  const std::string name = set_file_name(stack);
  Json entry{{"number", k}, {"name", stack.name}, {"file", name}, {"stack", stack.toml}};
  entry["parameters"] = Json::object();
  for (const auto& [path, value] : stack.values) entry["parameters"][path] = value;
  entry.update(made.about);
  entry["bytes"] = fs::file_size(folder / name);
  entry["sha256"] = content_hash_of_file(folder / name);
  return entry;
}

Json SampleSet::write_index(Json header) const {
  header["stacks"] = stacks_.size();
  header["done"] = done();
  header["entries"] = Json::array();
  for (const Json& entry : entries_)
    if (!entry.is_null()) header["entries"].push_back(entry);
  write_file(folder_ / "index.json", header.dump(1) + "\n");
  return header;
}

std::size_t SampleSet::done() const {
  std::size_t count = 0;
  for (const Json& entry : entries_) count += !entry.is_null();
  return count;
}

}  // namespace lamella
