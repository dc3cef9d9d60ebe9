#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdlib>

#include "compare/command.h"
#include "compare/output_folder.h"
#include "phase/stack_file.h"

namespace lamella {
namespace {

void add_json(CLI::App& command, Options& options) {
  command.add_option("--json", options.json, "Write the answer as JSON to FILE, - for stdout")
      ->type_name("FILE");
  command.add_flag("--quiet", options.quiet, "No table, no progress");
}

void add_run_options(CLI::App& command, Options& options, std::string& walks) {
  command.add_option("STACK", options.stack,
                     "TOML file, - for stdin, or a built-in stack (lamella stacks)");
  command
      .add_option("--wi", options.incident,
                  "Incident direction THETA[,PHI] in degrees, repeatable; above 90: from below "
                  "(default 0, 30, 60, 80)")
      ->type_name("THETA[,PHI]")
      ->take_all()
      ->allow_extra_args(false);
  command.add_option("--walks", walks, "Walks per incident direction (default 1000000)")
      ->type_name("N");
  command
      .add_option("--target-error", options.target_error,
                  "Stop at this largest relative standard error of the lobe energies above 1e-3")
      ->check(CLI::PositiveNumber)
      ->type_name("E");
  command.add_option("--time", options.seconds, "Stop after S seconds per incident direction")
      ->check(CLI::PositiveNumber)
      ->type_name("S");
  command
      .add_option("--max-order", options.max_order,
                  "Walks beyond it are cut and reported as unresolved (default 1000)")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 62))
      ->type_name("K");
  command.add_option("--estimator", options.estimator, "How light is counted (default auto)")
      ->check(CLI::IsMember({"auto", "analog", "next-event"}));
  command.add_option("--seed", options.seed, "Seed of the random numbers (default 1)")
      ->type_name("N");
  command.add_option("--threads", options.threads, "Threads (default: all)")
      ->check(CLI::Range(1, 4096))
      ->type_name("N");
  command.add_option("--isa", options.isa, "Instruction set of the kernels (default auto)")
      ->check(CLI::IsMember({"auto", "scalar"}));
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
      ->check(CLI::NonNegativeNumber)
      ->type_name("E");
}

int run_program(int argc, char** argv) {
  Options options;
  std::string walks;
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
  furnace->add_flag("--as-is", options.as_is, "Keep albedos, substrate and f0");
  furnace->add_flag("--strict", options.strict, "Exit 1 also when inconclusive");
  furnace->footer("Example: lamella furnace spongecake_two_layer --walks 1e5");

  CLI::App* bench = app.add_subcommand("bench", "Speed against error, with baselines");
  bench->add_option("--seed", options.seed, "Seed of the random numbers (default 1)")
      ->type_name("N");
  bench->add_option("--threads", options.threads, "Threads of the scaling row (default: all)")
      ->check(CLI::Range(1, 4096))
      ->type_name("N");
  bench->add_option("--isa", options.isa, "Instruction set of the kernels (default auto)")
      ->check(CLI::IsMember({"auto", "scalar"}));
  bench->add_flag("--quick", options.quick, "Every row in a few seconds: noisy");
  add_json(*bench, options);
  bench->footer("Example: lamella bench --json bench.json");

  CLI::App* eval = app.add_subcommand("eval", "Values of a model at direction pairs, as CSV");
  eval->add_option("MODEL", words, "Model or medium (see README), then key=value...")
      ->required()
      ->expected(1, -1);
  eval->add_option("--pairs", options.pairs, "CSV of direction pairs, - for stdin")
      ->required()
      ->type_name("FILE");
  eval->footer(
      "Example: printf 'mu_i,phi_i,mu_o,phi_o\\n0.5,0,0.8,90\\n' | lamella eval lambert albedo=0.5 "
      "--pairs -");

  CLI::App* explain = app.add_subcommand("explain", "What the walk models of a stack, and why");
  explain->add_option("STACK", options.stack, "TOML file, - for stdin, or a built-in stack");
  add_json(*explain, options);
  explain->footer("Example: lamella explain spongecake_plant");

  CLI::App* models = app.add_subcommand("models", "The closed forms: parameters, lobes, source");
  CLI::App* media = app.add_subcommand("media", "The media: keys, ranges, units, source");
  CLI::App* stacks = app.add_subcommand("stacks", "The built-in stacks");
  for (CLI::App* list : {models, media, stacks}) {
    add_json(*list, options);
    list->footer("Example: lamella " + list->get_name());
  }

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUsage;
  }
  if (!walks.empty()) options.walks = parse_walks(walks);

  std::signal(SIGINT, [](int) { interrupted = true; });
  std::optional<tbb::global_control> limit;
  const int threads = options.threads ? options.threads : tbb::this_task_arena::max_concurrency();
  // More threads than cores are allowed: the answer is the same for any number.
  limit.emplace(tbb::global_control::max_allowed_parallelism, threads);
  tbb::task_arena arena(threads);
  return arena.execute([&] {
    if (simulate->parsed()) return simulate_command(options);
    if (compare->parsed()) return compare_command(options);
    if (furnace->parsed()) return furnace_command(options);
    if (bench->parsed()) return bench_command(options);
    if (eval->parsed()) return eval_command(options, words);
    if (explain->parsed()) return explain_command(options);
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
    return lamella::run_program(argc, argv);
  } catch (const lamella::NonFiniteError& error) {
    return fail(error, lamella::kInvalidNumbers);
  } catch (const std::domain_error& error) {
    return fail(error, lamella::kInvalidNumbers);
  } catch (const std::exception& error) {
    return fail(error, lamella::kUsage);
  }
}
