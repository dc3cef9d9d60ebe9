#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "analytic/catalogue/model_plugin.h"
#include "compare/command/command.h"
#include "compare/command/divided_run.h"
#include "compare/files/content_hash.h"
#include "compare/options/progress.h"
#include "compare/options/run_settings.h"
#include "compare/report/input_files.h"
#include "compare/request/errors.h"
#include "compare/request/substrate_model.h"
#include "compare/shards/merged_keeper.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

// Direction pairs as CSV.
constexpr std::uint64_t kMostInputBytes = std::uint64_t{256} << 20;

const DividedCommand& command_of(const PartFile& part) {
  const std::string name = part.text("command");
  for (const DividedCommand* command : {&simulate_divided(), &compare_divided(), &furnace_divided(),
                                        &sweep_divided(), &eval_divided(), &samples_divided()})
    if (command->name == name) return *command;
  part.refuse(fmt::format("found a part of the command \"{}\"", name));
}

// The options that all parts had, with those of this command.
Options merged_options(const Options& own, Json settings, const PartFile& part) {
  for (const char* key : {"stack", "stack_name", "texels", "words", "input", "files"})
    settings.erase(key);
  Options options = options_from(settings, part.path().string());
  for (const std::string& model : options.models)
    if (is_plugin_path(parse_model_request(model).name))
      part.refuse("found a model in a shared object");
  options.output = own.output;
  options.json = own.json;
  options.html = own.html;
  options.quiet = own.quiet;
  options.threads = own.threads;
  options.walks_given = std::find(options.walk_settings.begin(), options.walk_settings.end(),
                                  WalkSetting::walks) != options.walk_settings.end();
  return options;
}

// Those of a mean over a map, none for other runs.
std::vector<Stack> texels_of(const PartFile& part, const std::string& where,
                             const std::string& name) {
  std::vector<Stack> texels;
  const Json texts = part.header().value("texels", Json::array());
  for (const Json& text : texts) {
    if (!text.is_string()) part.refuse("found texels that are none");
    texels.push_back(with_surface_model(parse_stack(text.get<std::string>(), where, name)));
  }
  if (part.header().at("settings").value("texels", Json()) != Json(content_hash(texts.dump())))
    part.refuse("its texels are not those of its settings: it is damaged");
  return texels;
}

std::vector<std::string> words_of(const PartFile& part, const Json& settings) {
  std::vector<std::string> words;
  for (const Json& word : settings.value("words", Json::array())) {
    if (!word.is_string()) part.refuse("found words that are none");
    words.push_back(word.get<std::string>());
  }
  return words;
}

// What each command can be told to write.
void check_output_of(const DividedCommand& command, const Options& options) {
  if (command.output.empty() && !options.output.empty())
    throw UsageError(
        fmt::format("-o: found \"{}\" for parts of {}; allowed: --json FILE, --html FILE.html",
                    options.output, command.name));
  if (command.output.starts_with("FILE.") && !options.output.empty() &&
      fs::path(options.output).extension() != command.output.substr(4) &&
      (!fs::exists(options.output) || fs::is_regular_file(options.output)))
    throw UsageError(
        fmt::format("-o: found \"{}\" for parts of {}; allowed: a name that ends in {}",
                    options.output, command.name, command.output.substr(4)));
  if (command.name != "furnace" && !options.html.empty())
    throw UsageError(fmt::format("--html: found it for parts of {}; allowed: for parts of furnace",
                                 command.name));
  if (command.name == "eval" && !options.json.empty())
    throw UsageError("--json: found it for parts of eval, which writes CSV; allowed: -o FILE.csv");
}

}  // namespace

int merge_command(const Options& options, const std::vector<std::string>& paths,
                  const std::vector<std::string>& pictures) {
  std::vector<std::unique_ptr<PartFile>> parts;
  for (const std::string& path : paths) parts.push_back(std::make_unique<PartFile>(path));
  check_parts(parts);
  const PartFile& first = *parts.front();
  const DividedCommand& command = command_of(first);
  const Json settings = first.header().value("settings", Json());
  if (!settings.is_object() || !settings.value("stack_name", Json()).is_string())
    first.refuse("found no settings in its header");
  const fs::path folder = first.path().parent_path();
  const std::string where = first.path().string();
  DividedRun run{command.name, merged_options(options, settings, first)};
  check_output_of(command, run.options);
  run.stack = with_found_files(
      with_surface_model(parse_stack(first.text("stack"), where, settings.value("stack_name", ""))),
      first.text("files"), folder, where);
  if (settings.value("stack", Json()) != Json(to_toml(with_bare_names(run.stack))))
    first.refuse("its stack is not that of its settings: it is damaged");
  run.texels = texels_of(first, where, run.stack.name);
  run.words = words_of(first, settings);
  run.pictures = pictures;
  run.folder = folder.string();
  if (first.has(kInputPiece)) run.input = first.piece(kInputPiece, kMostInputBytes);
  if (settings.value("input", Json()) != Json(content_hash(run.input)))
    first.refuse("its direction pairs are not those of its settings: it is damaged");
  command.check(run);
  MergedKeeper keeper(parts);
  RunMonitor monitor = terminal_monitor(run.options);
  monitor.keeper = &keeper;
  return command.finish(run, monitor);
}

}  // namespace lamella
