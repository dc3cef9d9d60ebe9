#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "compare/closed_form_command.h"
#include "compare/command.h"
#include "compare/command_words.h"
#include "compare/output_folder.h"
#include "phase/stack_file.h"

namespace lamella {
namespace {

// Checks of an option's text; they answer in the words of every other error. Numbers are handed on
// as digits.
CLI::Validator positive_number() {
  return {[](std::string& text) {
            const auto value = parse_number(text);
            if (value && *value > 0 && std::isfinite(*value)) return std::string();
            return fmt::format("found \"{}\"; allowed: a number in (0, inf)", text);
          },
          ""};
}

CLI::Validator number_from_zero() {
  return {[](std::string& text) {
            const auto value = parse_number(text);
            if (value && *value >= 0) return std::string();
            return fmt::format("found \"{}\"; allowed: a number in [0, inf]", text);
          },
          ""};
}

CLI::Validator whole_number(std::uint64_t from, std::uint64_t to) {
  return {[from, to](std::string& text) {
            const auto value = parse_whole_number(text);
            if (!value || *value < from || *value > to)
              return fmt::format("found \"{}\"; allowed: a whole number from {} to {}", text, from,
                                 to);
            text = fmt::format("{}", *value);
            return std::string();
          },
          ""};
}

CLI::Validator one_of(const std::vector<std::string>& words) {
  return {[words](std::string& text) {
            if (std::find(words.begin(), words.end(), text) != words.end()) return std::string();
            const std::string hint = suggestion(text, words);
            return fmt::format("found \"{}\"{}; allowed: {}", text, hint.empty() ? "" : ", " + hint,
                               listed(words));
          },
          ""};
}

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
void check_command(const CLI::App& app, int argc, char** argv) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  if (argc < 2)
    throw UsageError(fmt::format("found no command; allowed: {} (lamella --help)", listed(names)));
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

void add_json(CLI::App& command, Options& options) {
  command.add_option("--json", options.json, "Write the answer as JSON to FILE, - for stdout")
      ->type_name("FILE");
  command.add_flag("--quiet", options.quiet, "No table, no progress");
}

void add_html(CLI::App& command, Options& options) {
  command.add_option("--html", options.html, "Write the answer as a page to look at")
      ->type_name("FILE.html");
}

void add_walks(CLI::App& command, std::string& walks, const std::string& doc) {
  command.add_option("--walks", walks, doc + " (default 1000000)")
      ->transform(whole_number(kBatches, 1000000000000000))
      ->type_name("N");
}

void add_max_order(CLI::App& command, Options& options) {
  command
      .add_option("--max-order", options.max_order,
                  "Walks beyond it are cut and reported as unresolved (default 1000)")
      ->transform(whole_number(1, std::uint64_t{1} << 62))
      ->type_name("K");
}

void add_tolerance(CLI::App& command, Options& options) {
  command
      .add_option(
          "--tolerance", options.tolerance,
          "Largest error of the deterministic solver, relative to the mean over the azimuth "
          "(default 1e-6)")
      ->transform(positive_number())
      ->type_name("E");
}

void add_seed_and_threads(CLI::App& command, Options& options) {
  command.add_option("--seed", options.seed, "Seed of the random numbers (default 1)")
      ->transform(whole_number(0, std::numeric_limits<std::uint64_t>::max()))
      ->type_name("N");
  command.add_option("--threads", options.threads, "Threads (default: all)")
      ->transform(whole_number(1, 4096))
      ->type_name("N");
}

void add_isa(CLI::App& command, Options& options) {
  command
      .add_option(
          "--isa", options.isa,
          "Instruction set of the kernels (default auto: the widest of the machine, or what "
          "LAMELLA_ISA names)")
      ->transform(one_of({"auto", "scalar", "sse4", "avx2", "avx512"}))
      ->type_name("auto|scalar|sse4|avx2|avx512");
}

void add_stack(CLI::App& command, Options& options) {
  command.add_option("STACK", options.stack,
                     "TOML file, - for stdin, or a built-in stack (lamella stacks)");
}

void add_estimator(CLI::App& command, Options& options) {
  command.add_option("--estimator", options.estimator, "How light is counted (default auto)")
      ->transform(one_of({"auto", "analog", "next-event", "deterministic"}))
      ->type_name("auto|analog|next-event|deterministic");
  add_tolerance(command, options);
}

void add_run_options(CLI::App& command, Options& options, std::string& walks) {
  add_stack(command, options);
  command
      .add_option("--wi", options.incident,
                  "Incident direction THETA[,PHI] in degrees, repeatable; above 90: from below "
                  "(default 0, 30, 60, 80)")
      ->type_name("THETA[,PHI]")
      ->take_all()
      ->allow_extra_args(false);
  add_walks(command, walks, "Walks per incident direction");
  command
      .add_option("--target-error", options.target_error,
                  "Stop at this largest relative standard error of the lobe energies above 1e-3")
      ->transform(positive_number())
      ->type_name("E");
  command
      .add_option("--time", options.seconds,
                  "Stop after S seconds per incident direction; the solver: in all")
      ->transform(positive_number())
      ->type_name("S");
  add_max_order(command, options);
  add_estimator(command, options);
  add_seed_and_threads(command, options);
  add_isa(command, options);
  add_json(command, options);
}

void add_grid(CLI::App& command, Options& options) {
  command.add_option("--grid", options.grid, "Cells per hemisphere (default 16x32)")
      ->type_name("MUxPHI");
}

void add_model(CLI::App& command, Options& options, const std::string& doc) {
  command.add_option("--model", options.models, doc)
      ->type_name("NAME[,key=value...]")
      ->take_all()
      ->allow_extra_args(false);
  command
      .add_option("--max-error", options.max_error,
                  "Exit 1 if a model is farther off than this (see README)")
      ->transform(number_from_zero())
      ->type_name("E");
}

int run_program(int argc, char** argv) {
  Options options;
  ClosedFormOptions closed;
  bool sweep_parameters = false;
  std::string walks, shell;
  std::vector<std::string> words;
  CLI::App app{
      "Lamella simulates layered scattering media as ground truth for BSDF models and reports, "
      "lobe by lobe, how far closed forms are from it.",
      "lamella"};
  app.footer("Example: lamella compare lambert_sphere_halfspace --wi 60 --walks 1e5");
  app.set_version_flag("--version", std::string("lamella ") + LAMELLA_VERSION);
  app.require_subcommand(1);

  CLI::App* simulate = app.add_subcommand("simulate", "Ground-truth lobes of a stack");
  add_run_options(*simulate, options, walks);
  add_grid(*simulate, options);
  simulate->add_option("-o,--output", options.output, "Write the lobes to FILE.exr")
      ->type_name("FILE.exr");
  simulate->footer("Example: lamella simulate sggx_slab --wi 45 --walks 1e5 -o lobes.exr");

  CLI::App* compare = app.add_subcommand("compare", "Closed forms against ground truth");
  add_run_options(*compare, options, walks);
  add_grid(*compare, options);
  add_model(*compare, options, "A model to judge, repeatable (default: all that apply)");
  compare
      ->add_option("-o,--output", options.output,
                   "Folder for EXR, PNG and report (default "
                   "./NAME-compare)")
      ->type_name("FOLDER");
  compare->footer("Example: lamella compare spongecake_two_layer --wi 30 --walks 1e5");

  CLI::App* furnace = app.add_subcommand("furnace", "White furnace of a stack or of models");
  add_run_options(*furnace, options, walks);
  add_model(*furnace, options, "A closed form to check instead of the stack, repeatable");
  furnace->add_flag(
      "--sweep", sweep_parameters,
      "Models (--model, default all) over the whole range of their parameters: a table");
  furnace->add_flag("--as-is", options.as_is, "Keep albedos, substrate and f0");
  furnace->add_flag("--strict", options.strict, "Exit 1 also when inconclusive");
  add_html(*furnace, options);
  furnace->footer("Example: lamella furnace spongecake_two_layer --walks 1e5");

  CLI::App* homogenise = app.add_subcommand(
      "homogenise", "Depth profiles instead of density grids, and the error that makes");
  add_run_options(*homogenise, options, walks);
  add_grid(*homogenise, options);
  homogenise
      ->add_option("--contrast", options.contrasts,
                   "Share of the grids' lateral contrast to keep, repeatable (default 1)")
      ->type_name("F")
      ->take_all()
      ->allow_extra_args(false);
  homogenise->add_option("-o,--output", options.output, "Write the homogeneous stack to FILE.toml")
      ->type_name("FILE.toml");
  homogenise->footer("Example: lamella homogenise woven_cloth --wi 30 --walks 1e4 -o layers.toml");

  CLI::App* grid = app.add_subcommand("grid", "Makes a density grid; without KIND, what there is");
  grid->add_option("KIND", words, "weave, dust, blotches or spheres, then key=value...")
      ->expected(0, -1);
  grid->add_option("-o,--output", options.output, "The file to write")->type_name("FILE.vdb");
  add_json(*grid, options);
  grid->footer("Example: lamella grid weave pitch=0.5 voxels=32 -o cloth.vdb");

  CLI::App* bench = app.add_subcommand("bench", "Speed against error, with baselines");
  bench->add_option("--seed", options.seed, "Seed of the random numbers (default 1)")
      ->type_name("N");
  bench->add_option("--threads", options.threads, "Threads of the scaling row (default: all)")
      ->check(CLI::Range(1, 4096))
      ->type_name("N");
  add_isa(*bench, options);
  bench->add_flag("--quick", options.quick, "Every row in a few seconds: noisy");
  add_json(*bench, options);
  add_html(*bench, options);
  bench->footer("Example: lamella bench --quick --json bench.json");

  CLI::App* samplers =
      app.add_subcommand("samplers", "Variance and largest weight of models' samplers");
  add_model(*samplers, options, "A model, repeatable (default: EON's and VMF Diffuse's samplers)");
  samplers
      ->add_option("--wo", closed.outgoing, "THETA of w_o in degrees, repeatable (default 0 to 89)")
      ->type_name("THETA")
      ->take_all()
      ->allow_extra_args(false);
  samplers->add_option("--samples", closed.samples, "Draws per direction (default 100000)")
      ->transform(whole_number(2, 1000000000000))
      ->type_name("N");
  samplers->add_option("--seed", options.seed, "Seed of the random numbers (default 1)")
      ->transform(whole_number(0, std::numeric_limits<std::uint64_t>::max()))
      ->type_name("N");
  add_json(*samplers, options);
  samplers->footer("Example: lamella samplers --model eon,roughness=1,sampler=cltc --wo 80");

  CLI::App* fit = app.add_subcommand("fit", "SpongeCake's two further lobes for a stack");
  fit->add_option("STACK", options.stack,
                  "TOML file, - for stdin, or a built-in stack of SGGX mirror flakes and "
                  "Henyey-Greenstein layers, four at most");
  add_walks(*fit, walks, "Walks per incident direction");
  add_max_order(*fit, options);
  add_seed_and_threads(*fit, options);
  fit->add_option("--sampling", closed.sampling,
                  "Instead: sampling lobes of a closed form with a roughness, as C++")
      ->type_name("NAME[,key=value...]");
  fit->add_option("-o,--output", options.output, "Write what was fitted to FILE")
      ->type_name("FILE");
  add_json(*fit, options);
  fit->footer("Example: lamella fit sggx_slab --walks 1e5");

  CLI::App* invert =
      app.add_subcommand("invert", "The single-scattering albedo that gives a colour");
  invert
      ->add_option(
          "WHAT", words,
          "Model, or stack (all its layers get the albedo), then color=R,G,B or one number "
          "and the model's key=value...")
      ->required()
      ->expected(1, -1);
  invert
      ->add_option(
          "--wi", options.incident,
          "THETA[,PHI] of the light in degrees: the colour is the directional albedo there "
          "(default 0)")
      ->type_name("THETA[,PHI]");
  invert->add_flag("--bond", closed.bond, "Light from everywhere instead: the Bond albedo");
  add_walks(*invert, walks, "Walks per evaluation, of a stack");
  add_max_order(*invert, options);
  add_seed_and_threads(*invert, options);
  add_json(*invert, options);
  invert->footer("Example: lamella invert vmf_diffuse color=0.8,0.4,0.2 roughness=0.5");

  CLI::App* accuracy = app.add_subcommand(
      "accuracy", "How far every closed form is from the truth, as a Markdown table");
  add_tolerance(*accuracy, options);
  accuracy->add_flag("--quick", options.quick, "One stack of each family");
  add_json(*accuracy, options);
  accuracy->footer("Example: lamella accuracy --quick");

  CLI::App* eval = app.add_subcommand("eval", "Values of a model at direction pairs, as CSV");
  eval->add_option("MODEL", words, "Model or medium (see README), then key=value...")
      ->required()
      ->expected(1, -1);
  eval->add_option("--pairs", options.pairs, "CSV of direction pairs, - for stdin")
      ->required()
      ->type_name("FILE");
  add_walks(*eval, walks, "Walks per incident direction, of truth");
  add_max_order(*eval, options);
  add_seed_and_threads(*eval, options);
  eval->footer(
      "Example: printf 'mu_i,phi_i,mu_o,phi_o\\n0.5,0,0.8,90\\n' | lamella eval lambert albedo=0.5 "
      "--pairs -");

  CLI::App* explain = app.add_subcommand("explain", "What the walk models of a stack, and why");
  explain->add_option("STACK", options.stack, "TOML file, - for stdin, or a built-in stack");
  add_max_order(*explain, options);
  add_isa(*explain, options);
  add_json(*explain, options);
  explain->footer("Example: lamella explain spongecake_plant");

  CLI::App* sweep = app.add_subcommand("sweep", "Compare or furnace over a grid of parameters");
  add_run_options(*sweep, options, walks);
  add_grid(*sweep, options);
  add_model(*sweep, options, "A model, repeatable (default: all that apply)");
  sweep
      ->add_option("--set", options.sets,
                   "A parameter and its values, repeatable: layer.N.KEY (N from 0 at the top) or "
                   "substrate.KEY, =FROM:TO:COUNT, =FROM:TO:COUNT:log or =A,B,...")
      ->required()
      ->type_name("PATH=VALUES")
      ->take_all()
      ->allow_extra_args(false);
  sweep->add_option("--of", options.of, "What runs at each point (default compare)")
      ->transform(one_of({"compare", "furnace"}))
      ->type_name("compare|furnace");
  sweep->add_flag("--as-is", options.as_is, "Furnaces keep albedos, substrate and f0");
  sweep
      ->add_option("-o,--output", options.output,
                   "Folder of answers and page; a sweep that was stopped goes on there (default "
                   "./NAME-sweep)")
      ->type_name("FOLDER");
  sweep->footer(
      "Example: lamella sweep sggx_slab --set layer.0.roughness=0.2:1:3 --wi 60 --walks 1e4");

  CLI::App* preview = app.add_subcommand("preview", "A sphere and a plane under light");
  add_stack(*preview, options);
  add_model(*preview, options, "A model to show beside the truth, repeatable (default: all)");
  preview->add_option("--light", options.light, "The lamp, from the viewer (default 45,45)")
      ->type_name("THETA[,PHI]");
  preview
      ->add_option("--environment", options.environment,
                   "Light from everywhere: uniform, or a lat-long picture (default uniform)")
      ->type_name("uniform|FILE.exr");
  preview->add_option("--size", options.size, "Pixels across (default 192)")
      ->transform(whole_number(16, 2048))
      ->type_name("N");
  add_walks(*preview, walks, "Walks per incident direction, where the stack is not solved");
  add_max_order(*preview, options);
  add_estimator(*preview, options);
  add_seed_and_threads(*preview, options);
  add_json(*preview, options);
  preview
      ->add_option("-o,--output", options.output, "Folder for EXR and PNG (default ./NAME-preview)")
      ->type_name("FOLDER");
  preview->footer("Example: lamella preview lambert_sphere_halfspace --size 64");

  CLI::App* show = app.add_subcommand("show", "What is in an EXR file, and how it was made");
  show->add_option("FILE", options.stack, "EXR file")->required()->type_name("FILE.exr");
  add_json(*show, options);
  show->footer(
      "Example: lamella simulate sggx_slab --wi 45 --walks 1e4 -o show.exr && lamella show "
      "show.exr");

  CLI::App* rerun = app.add_subcommand("rerun", "Repeat the run of an EXR file, bit by bit");
  rerun->add_option("FILE", options.stack, "EXR file of simulate or compare")
      ->required()
      ->type_name("FILE.exr");
  rerun->add_option("-o,--output", options.output, "Write the repeated file")
      ->type_name("FILE.exr");
  rerun->add_option("--threads", options.threads, "Threads (default: all)")
      ->transform(whole_number(1, 4096))
      ->type_name("N");
  add_json(*rerun, options);
  rerun->footer(
      "Example: lamella simulate sggx_slab --wi 45 --walks 1e4 -o again.exr && lamella rerun "
      "again.exr");

  CLI::App* completion = app.add_subcommand("completion", "A completion script for a shell");
  completion->add_option("SHELL", shell, "bash or zsh")
      ->required()
      ->transform(one_of({"bash", "zsh"}))
      ->type_name("bash|zsh");
  completion->footer("Example: lamella completion bash");
  CLI::App* man = app.add_subcommand("man", "The manual page, for man -l -");
  man->footer("Example: lamella man");

  CLI::App* measure = app.add_subcommand(
      "measure", "Explicit geometry as a medium: areas, normals, density, an equivalent stack");
  measure->add_option("STACK", options.stack, "TOML file, - for stdin, or a built-in stack");
  add_walks(*measure, walks, "Rays from above, and as many points");
  measure->add_option("--medium", options.medium, "Of the equivalent stack (default vmf_flake)")
      ->transform(one_of({"vmf_flake", "sggx", "lambert_sphere"}))
      ->type_name("vmf_flake|sggx|lambert_sphere");
  measure->add_option("-o,--output", options.output, "Write the equivalent stack to FILE.toml")
      ->type_name("FILE.toml");
  add_seed_and_threads(*measure, options);
  add_json(*measure, options);
  measure->footer("Example: lamella measure sphere_bed_dense --walks 1e5 -o equivalent.toml");

  std::string figure;
  CLI::App* reproduce =
      app.add_subcommand("reproduce", "A published figure, again, from explicit geometry");
  reproduce->add_option("NAME", figure, "The figure; without: lists what there is");
  add_walks(*reproduce, walks, "Walks or rays in all");
  reproduce->add_option("-o,--output", options.output, "Folder for the pictures (default ./NAME)")
      ->type_name("FOLDER");
  add_seed_and_threads(*reproduce, options);
  add_json(*reproduce, options);
  reproduce->footer("Example: lamella reproduce micrograin_figure_9 --walks 1e5");

  CLI::App* models = app.add_subcommand("models", "The closed forms: parameters, lobes, source");
  CLI::App* media = app.add_subcommand("media", "The media: keys, ranges, units, source");
  CLI::App* stacks = app.add_subcommand("stacks", "The built-in stacks");
  for (CLI::App* list : {models, media, stacks}) {
    add_json(*list, options);
    list->footer("Example: lamella " + list->get_name());
  }

  check_command(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ExtrasError&) {
    fail_extra(*app.get_subcommands().front());
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    const auto given = app.get_subcommands();
    throw UsageError(fmt::format("{} (see lamella{} --help)", error.what(),
                                 given.empty() ? "" : " " + given.front()->get_name()));
  }
  if (!options.json.empty() && options.json != "-") check_output_file(options.json);
  options.walks_given = !walks.empty();
  options.medium_given = measure->count("--medium") > 0;
  if (options.walks_given) options.walks = parse_walks(walks);
  for (const CLI::App* command : app.get_subcommands())
    for (const char* name : {"--walks", "--target-error", "--max-order", "--time"})
      if (const CLI::Option* option = command->get_option_no_throw(name); option && *option)
        options.walk_options.emplace_back(name);

  std::optional<tbb::global_control> limit;
  const int threads = options.threads ? options.threads : tbb::this_task_arena::max_concurrency();
  // More threads than cores are allowed: the answer is the same for any number.
  limit.emplace(tbb::global_control::max_allowed_parallelism, threads);
  tbb::task_arena arena(threads);
  return arena.execute([&] {
    if (simulate->parsed()) return simulate_command(options);
    if (compare->parsed()) return compare_command(options);
    if (furnace->parsed() && sweep_parameters) return furnace_sweep_command(options);
    if (furnace->parsed()) return furnace_command(options);
    if (homogenise->parsed()) return homogenise_command(options);
    if (grid->parsed()) return grid_command(options, words);
    if (bench->parsed()) return bench_command(options);
    if (samplers->parsed()) return samplers_command(options, closed);
    if (fit->parsed()) return fit_command(options, closed);
    if (invert->parsed()) return invert_command(options, closed, words);
    if (accuracy->parsed()) return accuracy_command(options);
    if (eval->parsed()) return eval_command(options, words);
    if (sweep->parsed()) return sweep_command(options);
    if (preview->parsed()) return preview_command(options);
    if (show->parsed()) return show_command(options);
    if (rerun->parsed()) return rerun_command(options);
    if (completion->parsed()) {
      fmt::print("{}", completion_script(app, shell));
      return kDone;
    }
    if (man->parsed()) {
      fmt::print("{}", man_page(app));
      return kDone;
    }
    if (explain->parsed()) return explain_command(options);
    if (measure->parsed()) return measure_command(options);
    if (reproduce->parsed()) return reproduce_command(options, figure);
    if (models->parsed()) return models_command(options);
    if (media->parsed()) return media_command(options);
    return stacks_command(options);
  });
}

}  // namespace
}  // namespace lamella

int main(int argc, char** argv) {
  const auto fail = [](const std::exception& error, int status) {
    fmt::print(stderr, "lamella: {}\n", error.what());
    return status;
  };
  try {
    const int status = lamella::run_program(argc, argv);
    if (std::fflush(stdout) != 0)
      throw lamella::OutputError(fmt::format("cannot write stdout: {}", std::strerror(errno)));
    return status;
  } catch (const lamella::NonFiniteError& error) {
    return fail(error, lamella::kInvalidNumbers);
  } catch (const std::domain_error& error) {
    return fail(error, lamella::kInvalidNumbers);
  } catch (const std::exception& error) {
    return fail(error, lamella::kUsage);
  }
}
