#include "compare/command_line/command_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>

#include "compare/files/output_folder.h"
#include "compare/ranks/ranks.h"
#include "compare/request/errors.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

[[noreturn]] void fail_unknown(const std::string& what, const std::string& word,
                               const std::vector<std::string>& allowed) {
  const std::string hint = suggestion(word, allowed);
  throw UsageError(fmt::format("{} \"{}\": unknown{}; allowed: {}", what, word,
                               hint.empty() ? "" : ", " + hint, listed(allowed)));
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    if (!option->get_lnames().empty()) names.push_back("--" + option->get_lnames().front());
  return names;
}

// CLI11 tells of a missing command before it tells of a wrong one.
void check_command(const CLI::App& app, char** argv) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  const std::string word = argv[1];
  if (!word.starts_with("-")) {
    if (std::find(names.begin(), names.end(), word) == names.end())
      fail_unknown("command", word, names);
  } else if (word != "--help" && word != "-h" && word != "--version") {
    fail_unknown("option", word, option_names(app));
  }
}

[[noreturn]] void fail_extra(const CLI::App& command) {
  const std::string word = command.remaining(true).front();
  if (word.starts_with("-") && word.size() > 1)
    fail_unknown("option", word.substr(0, word.find('=')), option_names(command));
  throw UsageError(
      fmt::format("{}: found \"{}\" beside what it takes; allowed: see lamella {} --help",
                  command.get_name(), word, command.get_name()));
}

// CLI11's "--walks: 1 required N missing" as every other error has it.
std::string in_our_words(const std::string& text) {
  static const std::string required = ": 1 required ", missing = " missing";
  const std::size_t at = text.find(required);
  if (at == std::string::npos || !text.ends_with(missing)) return text;
  const std::size_t from = at + required.size();
  return fmt::format("{}: found nothing; allowed: {}", text.substr(0, at),
                     text.substr(from, text.size() - from - missing.size()));
}

// Which commands ranks can share.
void check_ranks(const std::string& command, const Options& options, bool sweep_parameters,
                 const std::vector<std::string>& words) {
  constexpr std::array kShared{"simulate", "compare", "furnace", "sweep", "eval", "samples"};
  if (std::find(kShared.begin(), kShared.end(), command) == kShared.end() || sweep_parameters)
    throw UsageError(
        fmt::format("mpirun: found the command {}{}, which ranks cannot share; allowed: {}",
                    command, sweep_parameters ? " --sweep" : "", fmt::join(kShared, ", ")));
  if (options.stack == "-" || options.pairs == "-" ||
      std::find(words.begin(), words.end(), "-") != words.end())
    throw UsageError("mpirun: found -, stdin, which it gives to one rank; allowed: a file");
}

}  // namespace

CommandLine::CommandLine()
    : app("Lamella simulates layered scattering media as ground truth for BSDF models and reports, "
          "lobe by lobe, how far closed forms are from it.",
          "lamella") {
  app.footer("Example: lamella compare lambert_sphere_halfspace --wi 60 --walks 1e5");
  app.set_version_flag("--version", std::string("lamella ") + LAMELLA_VERSION);
  app.require_subcommand(1);
  define_stack_commands(*this);
  define_model_commands(*this);
  define_file_commands(*this);
}

CLI::App& CommandLine::add(const std::string& name, const std::string& doc,
                           const std::string& example, std::function<int()> run) {
  CLI::App* command = app.add_subcommand(name, doc);
  command->footer("Example: " + example);
  runs_.emplace_back(command, std::move(run));
  return *command;
}

std::optional<int> CommandLine::parse(int argc, char** argv) {
  if (argc < 2) {
    fmt::print("{}", app.help());
    return 0;
  }
  check_command(app, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ExtrasError&) {
    fail_extra(*app.get_subcommands().front());
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    const auto given = app.get_subcommands();
    throw UsageError(fmt::format("{} (see lamella{} --help)", in_our_words(error.what()),
                                 given.empty() ? "" : " " + given.front()->get_name()));
  }
  if (!options.json.empty() && options.json != "-") check_output_file(options.json);
  options.walks_given = !walks.empty();
  if (options.walks_given) options.walks = parse_walks(walks);
  for (const CLI::App* command : app.get_subcommands())
    for (const WalkSetting setting :
         {WalkSetting::walks, WalkSetting::target_error, WalkSetting::max_order,
          WalkSetting::thin_from, WalkSetting::seconds})
      if (const CLI::Option* option = command->get_option_no_throw(to_text(setting));
          option && *option)
        options.walk_settings.push_back(setting);
  return std::nullopt;
}

int CommandLine::run() const {
  const Ranks* const ranks = started_ranks();
  if (ranks)
    check_ranks(app.get_subcommands().front()->get_name(), options, sweep_parameters, words);
  // Ranks on one machine share its cores.
  const int own =
      std::max(1, tbb::this_task_arena::max_concurrency() / (ranks ? ranks->neighbours() : 1));
  const int threads = options.threads ? options.threads : own;
  // More threads than cores are allowed: the answer is the same for any number.
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  const CLI::App* given = app.get_subcommands().front();
  const auto found = std::find_if(runs_.begin(), runs_.end(),
                                  [given](const auto& run) { return run.first == given; });
  return arena.execute([&] { return found->second(); });
}

}  // namespace lamella
