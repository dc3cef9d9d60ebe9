#include <fmt/format.h>

#include <algorithm>

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

// "adding-doubling, bound 2.7e-07" or "analog, 4000000 walks, energies within 3.1e-04".
std::string method_text(const ReferenceMethod& method) {
  if (!method.is_bounded())
    return fmt::format("{}, {} walks, +- {:.1e}", method.name, method.walks, method.error);
  return fmt::format("{}, bound {:.1e}", method.name, method.error);
}

std::string entry_text(const LibraryEntry& entry) {
  return fmt::format("{:<28} {:<8} lobes: {}\n{:<37} points: {}; {:.1f} s\n", entry.name,
                     entry.group, method_text(entry.lobes), "", method_text(entry.points),
                     entry.seconds);
}

std::uint64_t bytes_of(const LibraryIndex& index) {
  std::uint64_t bytes = 0;
  for (const LibraryEntry& entry : index.entries)
    for (const EntryFile& file : entry.files) bytes += file.bytes;
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
      fmt::print(out, "{:>2} of {}  {}{}", number, of, entry_text(entry),
                 kept ? "          (was there)\n" : "");
      std::fflush(out);
    };
  const LibraryBuildResult result = build_library(build, monitor);
  if (!options.quiet)
    fmt::print(out, "wrote {}/: {} entries found, {} were there; {:.1f} MB in all\n{}",
               library.folder, result.found, result.kept, static_cast<double>(result.bytes) * 1e-6,
               result.interrupted ? "interrupted: the same command goes on\n" : "");
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
    for (const LibraryEntry* entry : chosen) {
      fmt::print(out, "{}", entry_text(*entry));
      if (library.only.empty()) continue;
      fmt::print(out, "{}", wrapped("  ", fmt::format("{} ({})", entry->about, entry->source)));
      if (!entry->lobes.reason.empty())
        fmt::print(out, "{}", wrapped("  ", "walks: " + entry->lobes.reason));
      for (const EntryFile& file : entry->files)
        fmt::print(out, "  {}  {} ({} bytes)\n", file.sha256, file.name, file.bytes);
      fmt::print(out, "\n{}\n", entry->stack);
    }
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
