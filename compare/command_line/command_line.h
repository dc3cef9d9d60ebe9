#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compare/command/command.h"
#include "compare/options/options.h"

namespace lamella {

/// The commands of the program as the parser knows them, and the values of options and arguments.
struct CommandLine {
  CommandLine();
  CommandLine(const CommandLine&) = delete;  // the parser points into it
  CommandLine& operator=(const CommandLine&) = delete;

  CLI::App app;
  Options options{};
  ClosedFormOptions closed{};
  CheckOptions checking{};
  TabulateOptions tabulate{};
  LibraryOptions library{};
  DatasetOptions dataset{};
  std::string walks{};                         ///< as typed
  std::string word{};                          ///< the one argument of commands that take one word
  std::vector<std::string> pictures{};         ///< --pictures: names of formats
  std::vector<std::string> words{};            ///< the arguments of commands that take several
  std::string format = "npz", size = "large";  ///< of export
  double collisions = 1e9;                     ///< of soak
  bool sweep_parameters = false;               ///< furnace --sweep

  /// Adds a command. `example`: a shell line that works as it stands, shown by --help, and run by a
  /// test; `run`: does it, and returns the exit status.
  CLI::App& add(const std::string& name, const std::string& doc, const std::string& example,
                std::function<int()> run);

  /// Reads the arguments. Throws UsageError; the exit status where --help, --version or nothing at
  /// all, which shows the help, ends the program.
  [[nodiscard]] std::optional<int> parse(int argc, char** argv);

  /// Runs the command that was given, with as many threads as were asked for.
  [[nodiscard]] int run() const;

 private:
  std::vector<std::pair<const CLI::App*, std::function<int()>>> runs_{};
};

/// The definitions of all commands, in the order of the overview: about stacks, closed forms,
/// files.
void define_stack_commands(CommandLine& line);
void define_model_commands(CommandLine& line);
void define_file_commands(CommandLine& line);

}  // namespace lamella
