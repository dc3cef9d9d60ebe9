#include <fmt/format.h>

#include <algorithm>

#include "compare/command/command.h"
#include "compare/command/picture_options.h"
#include "compare/files/folder_lock.h"
#include "compare/files/output_folder.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/report/wrapped_text.h"
#include "compare/reproduce/reproduction_list.h"
#include "compare/reproduce/reproduction_page.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"
#include "compare/request/stopwatch.h"
#include "volume/grains/grain_scene.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// Writes the list of what there is.
void list_reproductions(const Options& options, std::FILE* out, Json& answer) {
  answer["reproductions"] = Json::array();
  for (const Reproduction& r : reproductions()) {
    if (!options.quiet)
      fmt::print(out, "{}{}", wrapped(fmt::format("{:<25} ", r.name), r.doc),
                 wrapped(std::string(26, ' '), r.source));
    answer["reproductions"].push_back({{"name", r.name}, {"doc", r.doc}, {"source", r.source}});
  }
}

Json json_of(const std::vector<Finding>& findings) {
  Json all = Json::array();
  for (const Finding& f : findings)
    all.push_back({{"paper", f.paper}, {"here", f.here}, {"agrees", f.agrees}});
  return all;
}

// "6 rows and a.png b.png", "nothing".
std::string kept_text(std::size_t rows, const std::vector<std::string>& pictures) {
  std::string text;
  if (rows > 0) text = fmt::format("{} row{}", rows, rows == 1 ? "" : "s");
  if (!pictures.empty())
    text += fmt::format("{}{}", rows > 0 ? " and " : "", fmt::join(pictures, " "));
  return text.empty() ? "nothing" : text;
}

// Runs one and adds its answer to `to`.
void reproduce(const Reproduction& reproduction, const Options& options, std::FILE* out,
               const std::string& folder, const std::vector<std::string>& pictures, Json& to) {
  const Quality quality = quality_from_text(options.quality);
  ReproductionContext context{
      .seed = options.seed,
      .stop = &user_interrupt,
      .table = options.quiet ? nullptr : out,
      .folder = folder,
      .formats = picture_formats_of(pictures),
      .walks = options.walks_given ? options.walks : reproduction.walks_of(quality),
      .quality = quality};
  if (context.table)
    fmt::print(out, "{}{}\n", wrapped(reproduction.name + ": ", reproduction.source, 4),
               wrapped("", reproduction.doc));
  to["walks"] = context.walks;
  const double seconds = wall_seconds_of([&] {
    try {
      to["rows"] = reproduction.run(context);
    } catch (const FigureStopped&) {
      to["rows"] = Json::array();
    }
  });
  to["findings"] = json_of(context.findings);
  to["pictures"] = context.pictures;
  to["seconds"] = seconds;
  to["interrupted"] = user_interrupt.load();
  if (user_interrupt && !options.quiet)
    fmt::print(stderr, "lamella: interrupted: {} is not whole; kept: {}\n", reproduction.name,
               kept_text(to["rows"].size(), context.pictures));
  if (!context.table || (context.pictures.empty() && !context.formats.empty())) return;
  if (context.formats.empty())
    fmt::print(out, "\n{}", absent_pictures_text());
  else
    fmt::print(out, "\n{}",
               wrapped(fmt::format("wrote {}/: ", context.folder),
                       fmt::format("{}", fmt::join(context.pictures, " ")), 4));
}

// All of them into folders of their own, and the page.
void reproduce_all(const Options& options, std::FILE* out, const std::string& folder,
                   const std::vector<std::string>& pictures, Json& answer) {
  answer["reproductions"] = Json::array();
  int agree = 0, findings = 0;
  for (const Reproduction& r : reproductions()) {
    Json entry{{"name", r.name}, {"doc", r.doc}, {"source", r.source}};
    if (is_set(&user_interrupt)) {
      entry["left_out"] = "the run was interrupted";
    } else if (r.has_grains && !GrainScene::is_available()) {
      entry["left_out"] = "explicit geometry needs a build with Embree";
    } else {
      const std::string own = folder + "/" + r.name;
      make_output_folder(own);
      reproduce(r, options, out, own, pictures, entry);
      if (!options.quiet) fmt::print(out, "\n");
      // What was cut short has no findings that count.
      if (is_set(&user_interrupt))
        entry = {{"name", r.name},
                 {"doc", r.doc},
                 {"source", r.source},
                 {"left_out", "the run was interrupted"}};
      else
        for (const Json& f : entry["findings"]) {
          agree += f["agrees"].get<bool>();
          ++findings;
        }
    }
    answer["reproductions"].push_back(std::move(entry));
  }
  const std::string page = folder + "/index.html";
  write_file(page, reproduction_page(answer));
  if (!options.quiet)
    fmt::print(out, "{} of {} findings agree with the papers\nwrote {}\n", agree, findings, page);
}

}  // namespace

int reproduce_command(const Options& options, const std::string& name,
                      const std::vector<std::string>& pictures) {
  std::FILE* out = table_stream(options);
  Json answer = json_header("reproduce", options.seed, isa_of(options));
  if (options.all_figures && !name.empty())
    throw UsageError(fmt::format("--all: found \"{}\" beside it; allowed: a name, or --all", name));
  if (name.empty() && !options.all_figures) {
    list_reproductions(options, out, answer);
    write_json(answer, options.json);
    return kDone;
  }
  const Reproduction* found = nullptr;
  if (!options.all_figures) {
    found = find_reproduction(name);
    if (!found) {
      std::vector<std::string> names;
      for (const Reproduction& r : reproductions()) names.push_back(r.name);
      const std::string hint = suggestion(name, names);
      throw UsageError(fmt::format("reproduction \"{}\": unknown{}; allowed: {}", name,
                                   hint.empty() ? "" : ", " + hint, listed(names)));
    }
    if (found->has_grains) GrainScene::require_available();
  }
  const std::string folder = !options.output.empty() ? options.output
                             : found                 ? found->name
                                                     : "lamella-reproduce";
  make_output_folder(folder);
  const FolderLock lock(folder);
  catch_interrupts();
  answer["quality"] = options.quality;
  if (found) {
    answer["name"] = found->name;
    answer["source"] = found->source;
    reproduce(*found, options, out, folder, pictures, answer);
  } else {
    reproduce_all(options, out, folder, pictures, answer);
  }
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
