#pragma once

#include "compare/command_line/command_line.h"

namespace lamella {

/// Checks of an option's text; they answer in the words of every other error. Whole numbers are
/// handed on as digits.
[[nodiscard]] CLI::Validator positive_number();
[[nodiscard]] CLI::Validator number_from_zero();
[[nodiscard]] CLI::Validator whole_number(std::uint64_t from, std::uint64_t to);
/// Any text except an empty one, which would otherwise count as an option that was not given.
[[nodiscard]] CLI::Validator named(const std::string& allowed);
inline constexpr const char* kAllowedStacks =
    "a TOML file, - for stdin, or a built-in stack (lamella stacks lists them)";
/// A model, or @FILE with one in it, which it becomes.
[[nodiscard]] CLI::Validator model_argument();
[[nodiscard]] CLI::Validator one_of(const std::vector<std::string>& words);
/// A file to write. Of a type like "FILE.exr": the name has that ending, or it is a device or pipe.
/// Of the type "FILE": every ending but those of other formats. Of the type "FOLDER": a name
/// without the ending of a format, or a folder that exists. Throws OutputError where it cannot be
/// written.
[[nodiscard]] CLI::Validator output_of(const std::string& type);

/// Options that several commands share.
void add_stack(CLI::App& command, CommandLine& line);
/// --at, which add_stack has too.
void add_at(CLI::App& command, CommandLine& line);
void add_json(CLI::App& command, CommandLine& line);
void add_html(CLI::App& command, CommandLine& line);
void add_walks(CLI::App& command, CommandLine& line, const std::string& doc,
               std::uint64_t standard = 1000000);
/// --max-order, --thin-from and, where `counted`, --sampling.
void add_walk_limits(CLI::App& command, CommandLine& line, bool counted = true);
void add_tolerance(CLI::App& command, CommandLine& line);
void add_estimator(CLI::App& command, CommandLine& line);
void add_seed(CLI::App& command, CommandLine& line);
void add_threads(CLI::App& command, CommandLine& line, const std::string& doc = "Threads");
void add_isa(CLI::App& command, CommandLine& line);
/// --wi.
void add_incident(CLI::App& command, CommandLine& line);
void add_grid(CLI::App& command, CommandLine& line);
void add_model(CLI::App& command, CommandLine& line, const std::string& doc);
void add_max_error(CLI::App& command, CommandLine& line);
/// --pictures: the formats of a command's pictures.
void add_pictures(CLI::App& command, CommandLine& line);
void add_output(CLI::App& command, CommandLine& line, const std::string& type,
                const std::string& doc);
/// --shard, and -o for the command's own output or a part file. `type`: of the own output; empty:
/// there is none.
void add_shard(CLI::App& command, CommandLine& line, const std::string& type,
               const std::string& doc);
void add_checkpoint(CLI::App& command, CommandLine& line);
/// Of commands that find the truth of a stack along incident directions. `target`: what else than a
/// stack the argument may be, as its help, which then is called TARGET.
void add_run_options(CLI::App& command, CommandLine& line, const std::string& target = "");

}  // namespace lamella
