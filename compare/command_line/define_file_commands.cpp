#include <fmt/format.h>

#include <filesystem>

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

// A part file is there; what is in it is its reader's to tell.
CLI::Validator part_argument() {
  return {[](std::string& text) {
            if (!text.empty() && std::filesystem::exists(text)) return std::string();
            return fmt::format("found \"{}\", which is not there; allowed: a part file", text);
          },
          ""};
}

void define_merge(CommandLine& line) {
  CLI::App& command =
      line.add("merge", "The parts of a run (--shard) put together",
               "for i in 1 2; do lamella simulate sggx_slab --wi 45 --walks 1e4 --shard $i/2 -o "
               "$i.part; done; lamella merge 1.part 2.part -o merged.exr",
               [&] { return merge_command(line.options, line.words, line.pictures); });
  command.add_option("PART", line.words, "All part files of the run, in any order")
      ->transform(part_argument())
      ->required()
      ->expected(1, -1);
  command
      .add_option("-o,--output", line.options.output,
                  "What the run would have written: FILE.exr of simulate, the folder of compare "
                  "and sweep, FILE.csv of eval")
      ->transform(named("a file or folder to write"))
      ->type_name("RESULT");
  add_pictures(command, line);
  add_html(command, line);
  add_threads(command, line);
  add_json(command, line);
}

void add_wi(CLI::App& command, CommandLine& line) {
  command
      .add_option("--wi", line.options.incident,
                  "Incident direction THETA[,PHI] in degrees, repeatable (default 0, 30, 60, 80)")
      ->type_name("THETA[,PHI]")
      ->take_all()
      ->allow_extra_args(false);
}

void define_library(CommandLine& line) {
  CLI::App& command = line.add(
      "library", "Reference lobes of many stacks, for the tests of other programs",
      "lamella library build mine --only isotropic_halfspace && lamella library verify mine",
      [&] { return library_command(line.options, line.library); });
  command
      .add_option("ACTION", line.library.action,
                  "build: finds what is not there yet; verify: finds some entries again; show")
      ->transform(one_of({"build", "verify", "show"}))
      ->required()
      ->type_name("build|verify|show");
  command
      .add_option("FOLDER", line.library.folder,
                  fmt::format("The library's folder (default ./{})", kLibraryFolder))
      ->transform(named("a folder"));
  command.add_option("--only", line.library.only, "These entries alone, with commas between them")
      ->delimiter(',')
      ->transform(named("an entry that lamella library show lists"))
      ->type_name("ENTRY,...");
  command
      .add_option("--sample", line.library.sample,
                  "verify: entries that are found again, drawn with --seed (default 3)")
      ->transform(whole_number(1, 1000000))
      ->type_name("N");
  command.add_flag("--all", line.library.all, "verify: every entry is found again");
  command.add_flag("--by-walks", line.library.by_walks,
                   "verify: by walks, whichever method found the entry");
  command
      .add_option("--time", line.options.seconds,
                  "Seconds per entry: of the solver, then of walks (default 120)")
      ->transform(positive_number())
      ->type_name("S");
  add_walks(command, line, "Walks per incident direction, where the solver does not apply",
            4000000);
  add_seed(command, line);
  add_threads(command, line);
  add_isa(command, line);
  add_json(command, line);
}

void define_scaling(CommandLine& line) {
  CLI::App& command = line.add("scaling", "What a run costs on 1 to 1000 ranks of mpirun",
                               "lamella scaling vmf_sand --wi 45 --walks 1e9",
                               [&] { return scaling_command(line.options); });
  add_stack(command, line);
  add_wi(command, line);
  add_walks(command, line, "Walks per incident direction of the run that is asked about");
  add_estimator(command, line);
  add_grid(command, line);
  add_seed(command, line);
  add_threads(command, line);
  add_isa(command, line);
  add_json(command, line);
}

void define_soak(CommandLine& line) {
  CLI::App& command = line.add("soak", "Walks of four stacks against the solver, cell by cell",
                               "lamella soak --collisions 1e6 -o soaked",
                               [&] { return soak_command(line.options, line.collisions); });
  command
      .add_option(
          "--collisions", line.collisions,
          "Of all walks together (default 1e9); the same command goes on where it was ended")
      ->transform(whole_number(1000000, 1000000000000000))
      ->type_name("N");
  add_output(command, line, "FOLDER",
             "Folder of the table and checkpoints (default ./lamella-soak)");
  add_seed(command, line);
  add_threads(command, line);
  add_isa(command, line);
  add_json(command, line);
}

void define_dataset(CommandLine& line) {
  CLI::App& command =
      line.add("dataset", "Random SpongeCake stacks with their multiple scattering, for training",
               "lamella dataset --layers 1 --stacks 50 --walks 2048 -o spongecakes",
               [&] { return dataset_command(line.options, line.dataset); });
  command.add_option("--layers", line.dataset.layers, "Layers per stack (default 1)")
      ->transform(whole_number(1, 4))
      ->type_name("N");
  command
      .add_option("--stacks", line.dataset.stacks,
                  "Stacks (default 4000 of one layer, 12000 of more, as the paper has)")
      ->transform(whole_number(1, 1000000))
      ->type_name("N");
  command
      .add_option("--directions", line.dataset.directions,
                  "Incident directions per stack (default 8)")
      ->transform(whole_number(1, 256))
      ->type_name("N");
  command.add_option("--grid", line.dataset.grid, "Cells per hemisphere MUxPHI (default 8x16)")
      ->type_name("MUxPHI");
  add_walks(command, line, "Walks per incident direction", 32768);
  add_seed(command, line);
  add_threads(command, line);
  add_shard(command, line, "FOLDER",
            "The folder of the set; the same command goes on where it was ended");
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
      "reproduce", "Published figures, again", "lamella reproduce micrograin_figure_9 --walks 1e5",
      [&] { return reproduce_command(line.options, line.word, line.pictures); });
  command.add_option("NAME", line.word, "The figure; without: lists what there is")
      ->transform(named("a name of the list"));
  command.add_flag("--all", line.options.all_figures,
                   "All figures, and a page that shows them, index.html");
  command
      .add_option(
          "--quality", line.options.quality,
          "draft: seconds a figure, to see that it runs; quick (default): under a minute on "
          "two cores; final: minutes")
      ->transform(one_of({"draft", "quick", "final"}))
      ->type_name("draft|quick|final");
  add_walks(command, line, "Walks or rays in all (default: by the quality)");
  add_pictures(command, line);
  add_output(command, line, "FOLDER",
             "Folder for the pictures (default ./NAME; of all ./lamella-reproduce)");
  add_seed(command, line);
  add_threads(command, line);
  add_json(command, line);
}

void add_export_source(CLI::App& command, CommandLine& line, const std::string& doc,
                       const std::string& type) {
  command.add_option("SOURCE", line.options.stack, doc)
      ->transform(named("a name or a file"))
      ->required()
      ->type_name(type);
}

void define_export(CommandLine& line) {
  CLI::App& command =
      line.add("export", "A truth, a closed form or lobes in another program's format",
               "lamella export eon,albedo=0.8,roughness=0.5 --to mitsuba -o eon.bsdf",
               [&] { return export_command(line.options, line.format, line.size); });
  add_export_source(command, line,
                    "A stack (its truth), a model as --model takes it, or an EXR file of lobes",
                    "SOURCE");
  add_at(command, line);
  command
      .add_option("--to", line.format,
                  "mitsuba: tensor file of RGB; pbrt: of spectra; merl; npz, csv: lobes on cells")
      ->required()
      ->transform(one_of({"mitsuba", "pbrt", "merl", "npz", "csv"}))
      ->type_name("mitsuba|pbrt|merl|npz|csv");
  command.add_option("--size", line.size, "Of tensor files (default large); all three are told")
      ->transform(one_of({"small", "medium", "large"}))
      ->type_name("small|medium|large");
  command.add_option("-o,--output", line.options.output, "The file to write")
      ->required()
      ->transform(named("a file to write"))
      ->type_name("FILE");
  add_wi(command, line);
  add_walks(command, line, "Walks per incident direction");
  add_estimator(command, line);
  add_seed(command, line);
  add_threads(command, line);
  add_grid(command, line);
  add_isa(command, line);
  add_json(command, line);
}

void define_import(CommandLine& line) {
  CLI::App& command =
      line.add("import", "A measured material (MERL or tensor file) as lobes",
               "lamella export lambert,albedo=0.5 --to mitsuba --size small -o grey.bsdf && "
               "lamella import grey.bsdf --wi 60 -o grey.exr",
               [&] { return import_command(line.options); });
  command.add_option("FILE", line.options.stack, "MERL (.binary) or tensor file (.bsdf)")
      ->transform(named("a MERL or tensor file"))
      ->required()
      ->type_name("FILE");
  add_output(command, line, "FILE.exr", "Write the lobes");
  add_wi(command, line);
  add_grid(command, line);
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
  define_merge(line);
  define_export(line);
  define_import(line);
  define_library(line);
  define_scaling(line);
  define_soak(line);
  define_dataset(line);
  define_grid(line);
  define_reproduce(line);
  define_completion(line);
  line.add("man", "The manual page, for man -l -", "lamella man", [&] {
    fmt::print("{}", man_page(line.app));
    return kDone;
  });
}

}  // namespace lamella
