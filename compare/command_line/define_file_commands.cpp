#include <fmt/format.h>

#include "compare/command/command.h"
#include "compare/command_line/command_words.h"
#include "compare/command_line/option_definitions.h"

namespace lamella {
namespace {

void define_show(CommandLine& line) {
  CLI::App& command = line.add(
      "show", "What is in an EXR file, and how it was made",
      "lamella simulate sggx_slab --wi 45 --walks 1e4 -o show.exr && lamella show show.exr",
      [&] { return show_command(line.options); });
  command.add_option("FILE", line.options.stack, "EXR file")
      ->transform(named("an EXR file"))
      ->required()
      ->type_name("FILE.exr");
  add_json(command, line);
}

void define_rerun(CommandLine& line) {
  CLI::App& command = line.add(
      "rerun", "Repeat the run of an EXR file, bit by bit",
      "lamella simulate sggx_slab --wi 45 --walks 1e4 -o again.exr && lamella rerun again.exr",
      [&] { return rerun_command(line.options); });
  command.add_option("FILE", line.options.stack, "EXR file of simulate or compare")
      ->transform(named("an EXR file"))
      ->required()
      ->type_name("FILE.exr");
  add_output(command, line, "FILE.exr", "Write the repeated file");
  add_threads(command, line);
  add_json(command, line);
}

void define_grid(CommandLine& line) {
  CLI::App& command = line.add("grid", "Makes a density grid; without KIND, what there is",
                               "lamella grid weave pitch=0.5 voxels=32 -o cloth.vdb",
                               [&] { return grid_command(line.options, line.words); });
  command.add_option("KIND", line.words, "weave, dust, blotches or spheres, then key=value...")
      ->transform(named("a kind, then key=value..."))
      ->expected(0, -1);
  add_output(command, line, "FILE.vdb", "The file to write");
  add_json(command, line);
}

void define_reproduce(CommandLine& line) {
  CLI::App& command = line.add(
      "reproduce", "A published figure, again", "lamella reproduce micrograin_figure_9 --walks 1e5",
      [&] { return reproduce_command(line.options, line.word, line.pictures); });
  command.add_option("NAME", line.word, "The figure; without: lists what there is")
      ->transform(named("a name of the list"));
  add_walks(command, line, "Walks or rays in all");
  add_pictures(command, line);
  add_output(command, line, "FOLDER", "Folder for the pictures (default ./NAME)");
  add_seed(command, line);
  add_threads(command, line);
  add_json(command, line);
}

void define_completion(CommandLine& line) {
  CLI::App& command =
      line.add("completion", "A completion script for a shell", "lamella completion bash", [&] {
        fmt::print("{}", completion_script(line.app, line.word));
        return kDone;
      });
  command.add_option("SHELL", line.word, "bash or zsh")
      ->required()
      ->transform(one_of({"bash", "zsh"}))
      ->type_name("bash|zsh");
}

}  // namespace

void define_file_commands(CommandLine& line) {
  define_show(line);
  define_rerun(line);
  define_grid(line);
  define_reproduce(line);
  define_completion(line);
  line.add("man", "The manual page, for man -l -", "lamella man", [&] {
    fmt::print("{}", man_page(line.app));
    return kDone;
  });
}

}  // namespace lamella
