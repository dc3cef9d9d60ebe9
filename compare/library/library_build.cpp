#include "compare/library/library_build.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "compare/files/content_hash.h"
#include "compare/files/exr_file.h"
#include "compare/files/folder_lock.h"
#include "compare/files/output_folder.h"
#include "phase/stack/stack_file.h"
#include "volume/grains/grain_scene.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

std::string grid_text(const CellGrid& grid) {
  return fmt::format("{}x{}", grid.mu_cells, grid.phi_cells);
}

EntryFile file_entry(const fs::path& path) {
  return {path.filename().string(), fs::file_size(path), content_hash_of_file(path)};
}

bool is_there(const LibraryEntry* entry, const std::string& stack, const LibraryBuild& build) {
  return entry && entry->stack == stack && entry->version == LAMELLA_VERSION &&
         entry->grid == grid_text(build.effort.cells) && !why_not_whole(*entry, build.folder);
}

std::optional<LibraryEntry> find_entry(const LibraryStack& of, const std::string& stack,
                                       const LibraryBuild& build, const RunMonitor& monitor) {
  const auto start = std::chrono::steady_clock::now();
  ExrImage image;
  const auto found = find_reference(of.stack, build.effort, monitor, &image);
  if (!found) return std::nullopt;
  const fs::path base = build.folder / of.name;
  const auto named = [&](const char* ending) { return fs::path(base.string() + ending); };
  write_file(named(".npz"), reference_npz(*found));
  write_exr(named(".exr"), image);
  write_file(named(".csv"), reference_csv(*found));
  LibraryEntry entry{.name = of.name,
                     .group = of.group,
                     .about = of.about,
                     .source = of.source,
                     .stack = stack,
                     .version = LAMELLA_VERSION,
                     .channels = found->set.channels,
                     .grid = grid_text(build.effort.cells),
                     .seed = build.effort.seed,
                     .lobes = found->lobe_method,
                     .points = found->point_method,
                     .pairs = found->pairs.size()};
  for (const char* ending : {".npz", ".exr", ".csv"})
    entry.files.push_back(file_entry(named(ending)));
  entry.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return entry;
}

// In the library's order; entries of other programs' making stay at the end.
void put(LibraryIndex& index, LibraryEntry entry, const std::vector<LibraryStack>& stacks) {
  std::erase_if(index.entries, [&](const LibraryEntry& e) { return e.name == entry.name; });
  index.entries.push_back(std::move(entry));
  const auto place = [&](const LibraryEntry& e) {
    return std::find_if(stacks.begin(), stacks.end(),
                        [&](const LibraryStack& s) { return s.name == e.name; }) -
           stacks.begin();
  };
  std::stable_sort(index.entries.begin(), index.entries.end(),
                   [&](const auto& a, const auto& b) { return place(a) < place(b); });
}

}  // namespace

LibraryBuildResult build_library(const LibraryBuild& build, const RunMonitor& monitor) {
  const std::vector<LibraryStack> stacks = library_stacks();
  std::vector<std::string> names;
  for (const LibraryStack& stack : stacks) names.push_back(stack.name);
  check_names(build.only, names, "--only");
  make_output_folder(build.folder);
  const FolderLock lock(build.folder);
  LibraryIndex index;
  if (fs::exists(build.folder / kIndexName)) index = read_index(build.folder);
  LibraryBuildResult result;
  const std::size_t count = build.only.empty() ? stacks.size() : build.only.size();
  std::size_t number = 0;
  for (const LibraryStack& of : stacks) {
    if (!build.only.empty() &&
        std::find(build.only.begin(), build.only.end(), of.name) == build.only.end())
      continue;
    ++number;
    const std::string stack = to_toml(of.stack);
    if (const LibraryEntry* there = index.find(of.name); is_there(there, stack, build)) {
      ++result.kept;
      if (build.done) build.done(*there, number, count, true);
      continue;
    }
    std::optional<LibraryEntry> entry;
    try {
      if (of.stack.grains() && !of.stack.grains()->is_height_field())
        GrainScene::require_available();
      entry = find_entry(of, stack, build, monitor);
    } catch (const GeometryError& error) {
      result.refused.push_back(fmt::format("{}: {}", of.name, error.what()));
      continue;
    }
    if (monitor.finished) monitor.finished();
    if (!entry) {
      result.interrupted = true;
      break;
    }
    put(index, *entry, stacks);
    write_file(build.folder / kIndexName, to_text(index));
    ++result.found;
    if (build.done) build.done(*entry, number, count, false);
  }
  for (const LibraryEntry& entry : index.entries)
    for (const EntryFile& file : entry.files) result.bytes += file.bytes;
  return result;
}

}  // namespace lamella
