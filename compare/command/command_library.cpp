#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "compare/command/command.h"
#include "compare/library/library_build.h"
#include "compare/library/library_verify.h"
#include "compare/options/progress.h"
#include "compare/report/check_report.h"
#include "compare/report/json_report.h"
#include "compare/report/wrapped_text.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

ReferenceEffort effort_of(const Options& options, const LibraryOptions& library) {
  ReferenceEffort effort;
  effort.seconds = options.seconds.value_or(effort.seconds);
  if (options.walks_given) effort.walks = options.walks;
  effort.seed = options.seed;
  effort.isa = isa_of(options);
  effort.walks_only = library.by_walks;
  return effort;
}

// "adding-doubling     2.7e-07", with * where that is not the tolerance, or "analog +- 3.1e-04".
std::string method_text(const ReferenceMethod& method) {
  if (!method.is_bounded()) return fmt::format("{:<15} +- {:.1e} ", method.name, method.error);
  return fmt::format("{:<15}    {:.1e}{}", method.name, method.error, method.reached() ? " " : "*");
}

std::uint64_t bytes_of(const LibraryEntry& entry) {
  std::uint64_t bytes = 0;
  for (const EntryFile& file : entry.files) bytes += file.bytes;
  return bytes;
}

// A row of 99 columns at most.
std::string entry_text(const LibraryEntry& entry) {
  return fmt::format("{:<26} {}  {}  {:>4.0f} kB {:>6.1f} s\n", entry.name,
                     method_text(entry.lobes), method_text(entry.points),
                     static_cast<double>(bytes_of(entry)) * 1e-3, entry.seconds);
}

constexpr char kColumns[] =
    "                           lobes                        points                          size  "
    "   "
    "time\n";
constexpr char kLegend[] =
    "of lobes the bound relative to the mean over the azimuth, of walks (+-) the largest relative\n"
    "standard error of an energy; of points the largest error relative to f; *: the time ended "
    "the\n"
    "solver before its tolerance\n";

// How many entries each method has.
std::string methods_text(const std::vector<const LibraryEntry*>& entries,
                         ReferenceMethod LibraryEntry::*of) {
  std::map<std::string, std::pair<int, int>> counts;  // all, and those within the tolerance
  for (const LibraryEntry* entry : entries) {
    const ReferenceMethod& method = entry->*of;
    ++counts[method.name].first;
    counts[method.name].second += method.is_bounded() && method.reached();
  }
  std::string text;
  for (const auto& [name, count] : counts)
    text += fmt::format(
        "{}{} by {}{}", text.empty() ? "" : ", ", count.first, name,
        count.second ? fmt::format(" ({} within the tolerance)", count.second) : std::string());
  return text;
}

std::uint64_t bytes_of(const LibraryIndex& index) {
  std::uint64_t bytes = 0;
  for (const LibraryEntry& entry : index.entries) bytes += bytes_of(entry);
  return bytes;
}

std::vector<const LibraryEntry*> chosen_of(const LibraryIndex& index,
                                           const std::vector<std::string>& only) {
  std::vector<std::string> names;
  for (const LibraryEntry& entry : index.entries) names.push_back(entry.name);
  check_names(only, names, "--only");
  std::vector<const LibraryEntry*> chosen;
  for (const LibraryEntry& entry : index.entries)
    if (only.empty() || std::find(only.begin(), only.end(), entry.name) != only.end())
      chosen.push_back(&entry);
  return chosen;
}

Json entries_json(const std::vector<const LibraryEntry*>& entries) {
  LibraryIndex index;
  for (const LibraryEntry* entry : entries) index.entries.push_back(*entry);
  return Json::parse(to_text(index))["entries"];
}

int build(const Options& options, const LibraryOptions& library, Json& answer) {
  const RunMonitor monitor = terminal_monitor(options);
  std::FILE* out = table_stream(options);
  LibraryBuild build{
      .folder = library.folder, .only = library.only, .effort = effort_of(options, library)};
  if (!options.quiet)
    build.done = [&](const LibraryEntry& entry, std::size_t number, std::size_t of, bool kept) {
      fmt::print(out, "{:>2} of {}{}\n{}", number, of, kept ? " (was there)" : "",
                 entry_text(entry));
      std::fflush(out);
    };
  const LibraryBuildResult result = build_library(build, monitor);
  if (!options.quiet)
    fmt::print(out, "wrote {}/: {} entries found, {} were there; {:.1f} MB in all\n{}",
               library.folder, result.found, result.kept, static_cast<double>(result.bytes) * 1e-6,
               result.interrupted ? "interrupted: the same command goes on\n" : "");
  for (const std::string& refused : result.refused)
    if (!options.quiet) fmt::print(out, "{}", wrapped("left out: ", refused));
  answer["refused"] = result.refused;
  answer["found"] = result.found;
  answer["kept"] = result.kept;
  answer["interrupted"] = result.interrupted;
  answer["bytes"] = result.bytes;
  if (result.found + result.kept > 0)
    answer["entries"] = entries_json(chosen_of(read_index(library.folder), {}));
  else
    answer["entries"] = Json::array();
  return kDone;
}

int verify(const Options& options, const LibraryOptions& library, Json& answer) {
  const RunMonitor monitor = terminal_monitor(options);
  std::FILE* out = table_stream(options);
  LibraryVerification verification{.folder = library.folder,
                                   .only = library.only,
                                   .sample = library.all ? 0 : library.sample,
                                   .effort = effort_of(options, library)};
  constexpr int kNameWidth = 28;
  if (!options.quiet)
    verification.done = [&](const CheckLine& line, const LibraryEntry&) {
      fmt::print(out, "{}", to_text(line, kNameWidth));
      std::fflush(out);
    };
  const LibraryVerificationResult result = verify_library(verification, monitor);
  const bool failed =
      !result.broken.empty() ||
      std::any_of(result.lines.begin(), result.lines.end(),
                  [](const CheckLine& line) { return line.verdict() == CheckVerdict::fail; });
  if (!options.quiet) {
    for (const std::string& broken : result.broken)
      fmt::print(out, "{}", wrapped("  fail       ", broken));
    fmt::print(out, "{}: {}; the files of {} entries read, {} of them found again\n",
               library.folder, failed ? "fail" : "pass", result.entries, result.lines.size());
    if (result.interrupted) fmt::print(out, "interrupted: what was done until then\n");
  }
  answer["verdict"] = failed ? "fail" : "pass";
  answer["entries_read"] = result.entries;
  answer["interrupted"] = result.interrupted;
  answer["broken"] = result.broken;
  answer["checks"] = Json::array();
  for (const CheckLine& line : result.lines) answer["checks"].push_back(to_json(line));
  return failed ? kFailed : kDone;
}

int show(const Options& options, const LibraryOptions& library, Json& answer) {
  const LibraryIndex index = read_index(library.folder);
  const std::vector<const LibraryEntry*> chosen = chosen_of(index, library.only);
  if (!options.quiet) {
    std::FILE* out = table_stream(options);
    fmt::print(out, "{}", kColumns);
    std::string group;
    for (const LibraryEntry* entry : chosen) {
      if (library.only.empty() && entry->group != group) fmt::print(out, "{}\n", entry->group);
      group = entry->group;
      fmt::print(out, "{}", entry_text(*entry));
      if (library.only.empty()) continue;
      fmt::print(out, "{}", wrapped("  ", fmt::format("{} ({})", entry->about, entry->source)));
      if (!entry->lobes.reason.empty())
        fmt::print(out, "{}", wrapped("  ", "walks: " + entry->lobes.reason));
      for (const EntryFile& file : entry->files)
        fmt::print(out, "  {}  {} ({} bytes)\n", file.sha256, file.name, file.bytes);
      fmt::print(out, "\n{}\n", entry->stack);
    }
    fmt::print(out, "{}{}{}", kLegend,
               wrapped("", "lobes: " + methods_text(chosen, &LibraryEntry::lobes)),
               wrapped("", "points: " + methods_text(chosen, &LibraryEntry::points)));
    fmt::print(out, "{}/: {} entries, {:.1f} MB\n", library.folder, index.entries.size(),
               static_cast<double>(bytes_of(index)) * 1e-6);
  }
  answer["bytes"] = bytes_of(index);
  answer["entries"] = entries_json(chosen);
  return kDone;
}

}  // namespace

int library_command(const Options& options, const LibraryOptions& of) {
  LibraryOptions library = of;
  if (library.folder.empty()) library.folder = kLibraryFolder;
  const bool verifies = library.action == "verify", builds = library.action == "build";
  if (!verifies && (library.all || library.by_walks || library.sample != LibraryOptions{}.sample))
    throw UsageError(fmt::format(
        "--sample, --all, --by-walks: found one beside {}; allowed: with verify", library.action));
  Json answer = json_header("library", options.seed, isa_of(options));
  answer["action"] = library.action;
  answer["folder"] = library.folder;
  const int status = builds     ? build(options, library, answer)
                     : verifies ? verify(options, library, answer)
                                : show(options, library, answer);
  write_json(answer, options.json);
  return status;
}

}  // namespace lamella
