#include <fmt/format.h>

#include "compare/command/command.h"
#include "compare/command_line/option_definitions.h"
#include "compare/request/numbers.h"

namespace lamella {
namespace {

void define_simulate(CommandLine& line) {
  CLI::App& command = line.add("simulate", "Ground-truth lobes of a stack",
                               "lamella simulate sggx_slab --wi 45 --walks 1e5 -o lobes.exr",
                               [&] { return simulate_command(line.options); });
  add_run_options(command, line);
  add_grid(command, line);
  add_shard(command, line, "FILE.exr", "Write the lobes to FILE.exr");
  add_checkpoint(command, line);
}

void define_compare(CommandLine& line) {
  CLI::App& command = line.add("compare", "Closed forms against ground truth",
                               "lamella compare spongecake_two_layer --wi 30 --walks 1e5",
                               [&] { return compare_command(line.options, line.pictures); });
  add_run_options(command, line);
  add_grid(command, line);
  add_model(command, line, "A model to judge, repeatable (default: all that apply)");
  command
      .add_option("--truth", line.options.truth_model,
                  "A closed form that is the truth, in the place of STACK")
      ->type_name("NAME[,key=value...]");
  add_max_error(command, line);
  command.add_flag("--preview", line.options.preview,
                   "Also a sphere and a plane under light, in the folder and in the report (see "
                   "lamella preview)");
  add_pictures(command, line);
  add_shard(command, line, "FOLDER",
            "Folder for EXR, pictures and report (default ./NAME-compare)");
  add_checkpoint(command, line);
}

void define_furnace(CommandLine& line) {
  CLI::App& command = line.add("furnace", "White furnace of a stack or of models",
                               "lamella furnace spongecake_two_layer --walks 1e5", [&] {
                                 return line.sweep_parameters ? furnace_sweep_command(line.options)
                                                              : furnace_command(line.options);
                               });
  add_run_options(command, line);
  add_model(command, line, "A closed form to check instead of the stack, repeatable");
  add_max_error(command, line);
  command.add_flag(
      "--sweep", line.sweep_parameters,
      "Models (--model, default all) over the whole range of their parameters: a table");
  command.add_flag("--as-is", line.options.as_is, "Keep albedos, substrate and f0");
  command.add_flag("--strict", line.options.strict, "Exit 1 also when inconclusive");
  add_html(command, line);
  add_shard(command, line, "", "");
}

void define_sweep(CommandLine& line) {
  CLI::App& command =
      line.add("sweep", "Compare or furnace over a grid of parameters",
               "lamella sweep sggx_slab --set layer.0.roughness=0.2:1:3 --wi 60 --walks 1e4",
               [&] { return sweep_command(line.options); });
  add_run_options(command, line);
  add_grid(command, line);
  add_model(command, line, "A model, repeatable (default: all that apply)");
  add_max_error(command, line);
  command
      .add_option("--set", line.options.sets,
                  "A parameter and its values, repeatable: layer.N.KEY (N from 0 at the top) or "
                  "substrate.KEY, =FROM:TO:COUNT, =FROM:TO:COUNT:log or =A,B,...")
      ->required()
      ->type_name("PATH=VALUES")
      ->take_all()
      ->allow_extra_args(false);
  command.add_option("--of", line.options.of, "What runs at each point (default compare)")
      ->transform(one_of({"compare", "furnace"}))
      ->type_name("compare|furnace");
  command.add_flag("--as-is", line.options.as_is, "Furnaces keep albedos, substrate and f0");
  add_shard(command, line, "FOLDER",
            "Folder of answers and page; a sweep that was stopped goes on there (default "
            "./NAME-sweep)");
  add_checkpoint(command, line);
}

void define_preview(CommandLine& line) {
  CLI::App& command = line.add("preview", "A sphere and a plane under light",
                               "lamella preview lambert_sphere_halfspace --size 64",
                               [&] { return preview_command(line.options, line.pictures); });
  add_stack(command, line);
  add_model(command, line, "A model to show beside the truth, repeatable (default: all)");
  command
      .add_option("--light", line.options.light,
                  "The lamp, from the viewer; with --shape also none (default 45,45)")
      ->type_name("THETA[,PHI]");
  command
      .add_option(
          "--environment", line.options.environment,
          "Light from everywhere: uniform, or a lat-long picture; with --shape also clear_sky, "
          "overcast_sky or none (default uniform)")
      ->transform(named("uniform, or an EXR file"))
      ->type_name("uniform|FILE.exr");
  command.add_option("--size", line.options.size, "Pixels across (default 192)")
      ->transform(whole_number(16, 2048))
      ->type_name("N");
  command
      .add_option(
          "--shape", line.options.shape,
          "Trace paths on one object, the truth by walks: sphere, plane, cloth, knot, or an "
          "OBJ file; any homogeneous stack, with maps, too")
      ->transform(named("sphere, plane, cloth, knot, or an OBJ file"))
      ->type_name("SHAPE");
  command
      .add_option("--depth", line.options.depth,
                  "With --shape, surfaces that a path may meet (default 4)")
      ->transform(whole_number(1, 1000))
      ->type_name("N");
  command
      .add_option_function<int>(
          "--samples",
          [&](int samples) {
            line.options.samples = samples;
            line.options.samples_given = true;
          },
          "With --shape, paths per pixel (default 64; with --time as many as it allows)")
      ->transform(whole_number(1, 1000000))
      ->type_name("N");
  command.add_flag("--white", line.options.white,
                   "With --shape, albedos, substrate and f0 at 1, as a white furnace has them");
  command.add_flag(
      "--table", line.options.table,
      "With --shape, also the truth by its table, as pictures without --shape have it");
  command
      .add_option("--time", line.options.seconds, "With --shape, end each picture after S seconds")
      ->transform(positive_number())
      ->type_name("S");
  command
      .add_option(
          "--equal-time", line.options.equal_time,
          "With --shape, S seconds for walks, each closed form and the table: speed against "
          "error, noise and bias apart")
      ->transform(positive_number())
      ->type_name("S");
  add_walks(command, line, "Walks per viewing direction, where the stack is not solved", 10000);
  add_walk_limits(command, line);
  add_estimator(command, line);
  add_seed(command, line);
  add_threads(command, line);
  add_json(command, line);
  add_pictures(command, line);
  add_output(command, line, "FOLDER", "Folder for EXR and pictures (default ./NAME-preview)");
}

CLI::Validator stack_design() {
  return {[](std::string& text) {
            constexpr std::uint64_t kMost = 1000000;
            const auto count =
                text.starts_with("latin:") ? parse_whole_number(text.substr(6)) : std::nullopt;
            if (count && *count >= 1 && *count <= kMost) return std::string();
            return fmt::format("found \"{}\"; allowed: latin:N, N from 1 to {}", text, kMost);
          },
          ""};
}

void define_samples(CommandLine& line) {
  CLI::App& command =
      line.add("samples", "Walks one by one, as arrays for training",
               "lamella samples sggx_slab --wi-distribution cosine --walks 1e5 -o walks.npz",
               [&] { return samples_command(line.options, line.words); });
  command
      .add_option("STACK", line.words,
                  "TOML file, - for stdin, or a built-in stack (lamella stacks); several with "
                  "--per-bsdf")
      ->transform(named(kAllowedStacks))
      ->expected(0, -1);
  add_at(command, line);
  add_incident(command, line);
  command
      .add_option("--wi-distribution", line.options.incident_law,
                  "Every walk draws its w_i over the upper hemisphere: uniformly per solid angle, "
                  "or by the cosine (instead of --wi)")
      ->transform(one_of({"uniform", "cosine"}))
      ->type_name("uniform|cosine");
  add_walks(command, line, "Walks per incident direction");
  add_walk_limits(command, line, false);
  add_seed(command, line);
  add_threads(command, line);
  add_isa(command, line);
  add_json(command, line);
  command.add_flag("--per-bsdf", line.options.per_bsdf,
                   "A data set: a file per stack in a folder, and an index; the same command goes "
                   "on where it was stopped");
  command
      .add_option("--set", line.options.sets,
                  "With --per-bsdf, a parameter and its values, repeatable: layer.N.KEY (N from 0 "
                  "at the top) or substrate.KEY, as in sweep; with --design =FROM:TO, =FROM:TO:log "
                  "or =A,B,...")
      ->type_name("PATH=VALUES")
      ->take_all()
      ->allow_extra_args(false);
  command
      .add_option("--design", line.options.design,
                  "With --per-bsdf, N stacks at random over the ranges of --set (a Latin "
                  "hypercube)")
      ->transform(stack_design())
      ->type_name("latin:N");
  command.add_flag("--lobes", line.options.lobes,
                   "With --per-bsdf, files of lobes on cells in the place of walks");
  add_grid(command, line);
  add_estimator(command, line);
  add_shard(command, line, "FILE.npz|FOLDER", "The archive to write; with --per-bsdf a folder");
}

void define_homogenise(CommandLine& line) {
  CLI::App& command =
      line.add("homogenise", "Depth profiles instead of density grids, and the error that makes",
               "lamella homogenise woven_cloth --wi 30 --walks 1e4 -o layers.toml",
               [&] { return homogenise_command(line.options); });
  add_run_options(command, line);
  add_grid(command, line);
  command
      .add_option("--contrast", line.options.contrasts,
                  "Share of the grids' lateral contrast to keep, repeatable (default 1)")
      ->type_name("F")
      ->take_all()
      ->allow_extra_args(false);
  add_output(command, line, "FILE.toml", "Write the homogeneous stack to FILE.toml");
}

void define_explain(CommandLine& line) {
  CLI::App& command =
      line.add("explain", "What the walk models of a stack, and why",
               "lamella explain spongecake_plant", [&] { return explain_command(line.options); });
  add_stack(command, line);
  add_walk_limits(command, line);
  add_isa(command, line);
  add_json(command, line);
}

void define_measure(CommandLine& line) {
  CLI::App& command = line.add(
      "measure", "Explicit geometry as a medium: areas, normals, density, an equivalent stack",
      "lamella measure sphere_bed_dense --walks 1e5 -o equivalent.toml",
      [&] { return measure_command(line.options); });
  add_stack(command, line);
  add_walks(command, line,
            "Rays from above, and as many points; with --fit also walks per incident direction");
  command
      .add_option_function<std::string>(
          "--medium",
          [&](const std::string& medium) {
            line.options.medium = medium;
            line.options.medium_given = true;
          },
          "Of the equivalent stack (default vmf_flake)")
      ->transform(one_of({"vmf_flake", "sggx", "lambert_sphere"}))
      ->type_name("vmf_flake|sggx|lambert_sphere");
  command.add_flag("--fit", line.options.fit,
                   "Also by lobes: the roughness with which the medium, and the closed form "
                   "vmf_diffuse, come nearest to walks among the grains");
  add_incident(command, line);
  add_grid(command, line);
  add_output(command, line, "FILE.toml", "Write the equivalent stack to FILE.toml");
  add_seed(command, line);
  add_threads(command, line);
  add_json(command, line);
}

}  // namespace

void define_stack_commands(CommandLine& line) {
  define_simulate(line);
  define_compare(line);
  define_furnace(line);
  define_sweep(line);
  define_preview(line);
  define_samples(line);
  define_homogenise(line);
  define_explain(line);
  define_measure(line);
}

}  // namespace lamella
