#include <fmt/format.h>

#include "compare/command/command.h"
#include "compare/command_line/option_definitions.h"

namespace lamella {
namespace {

void define_eval(CommandLine& line) {
  CLI::App& command = line.add("eval", "Values of a model at direction pairs, as CSV",
                               "printf 'mu_i,phi_i,mu_o,phi_o\\n0.5,0,0.8,90\\n' | lamella eval "
                               "lambert albedo=0.5 --pairs -",
                               [&] { return eval_command(line.options, line.words); });
  command.add_option("MODEL", line.words, "Model or medium (see README), then key=value...")
      ->transform(named("a model, then key=value..."))
      ->required()
      ->expected(1, -1);
  command.add_option("--pairs", line.options.pairs, "CSV of direction pairs, - for stdin")
      ->transform(named("a CSV file of direction pairs, or -"))
      ->required()
      ->type_name("FILE");
  add_at(command, line);
  add_walks(command, line, "Walks per incident direction, of truth");
  add_walk_limits(command, line);
  add_seed(command, line);
  add_threads(command, line);
  add_shard(command, line, "FILE.csv", "Write the values there instead of stdout");
}

void define_tabulate(CommandLine& line) {
  CLI::App& command =
      line.add("tabulate", "Series of a closed form or a phase function, and albedos, as CSV",
               "lamella tabulate media.henyey_greenstein g=0.7 --of legendre --terms 16",
               [&] { return tabulate_command(line.options, line.tabulate, line.words); });
  command
      .add_option(
          "MODEL", line.words,
          "A closed form, or the phase function of a medium (media.NAME), then key=value...")
      ->transform(named("a model, or media.NAME, then key=value..."))
      ->required()
      ->expected(1, -1);
  command
      .add_option("--of", line.tabulate.of,
                  "Fourier coefficients in the azimuth (default), Legendre's of a phase function, "
                  "or albedos")
      ->transform(one_of({"fourier", "legendre", "albedo"}))
      ->type_name("fourier|legendre|albedo");
  command.add_option("--terms", line.tabulate.terms, "Terms of the series (default 8)")
      ->transform(whole_number(1, 256))
      ->type_name("N");
  for (const auto& [name, list, doc] : {std::tuple{"--mu-i", &line.tabulate.mu_i, "Cosine of w_i"},
                                        std::tuple{"--mu-o", &line.tabulate.mu_o, "Cosine of w_o"}})
    command
        .add_option(
            name, *list,
            fmt::format("{}, repeatable; below 0: from below (default 1, 0.9, ... 0.1)", doc))
        ->type_name("MU")
        ->take_all()
        ->allow_extra_args(false);
  add_output(command, line, "FILE.csv", "Write the table there instead of stdout");
  add_json(command, line);
}

void define_accuracy(CommandLine& line) {
  CLI::App& command =
      line.add("accuracy", "How far every closed form is from the truth, as a Markdown table",
               "lamella accuracy --coats --quick", [&] { return accuracy_command(line.options); });
  add_tolerance(command, line);
  command.add_flag("--quick", line.options.quick, "One stack of each family");
  command.add_flag("--coats", line.options.coats,
                   "Instead: every layering of a coat over Lambert's law, by index, roughness and "
                   "albedo of the base");
  command.add_flag("--spongecake", line.options.spongecake,
                   "Instead: SpongeCake's lobes of multiple scattering, none, of the network and "
                   "fitted, on 250 random stacks of one layer and 250 of two (--quick: 8 and 8)");
  add_walks(command, line, "Walks per incident direction of --spongecake", 131072);
  add_output(command, line, "FOLDER", "Pictures of the worst stacks of --spongecake, as PNG");
  add_json(command, line);
}

void define_bench(CommandLine& line) {
  CLI::App& command = line.add("bench", "Speed against error, with baselines",
                               "lamella bench --quick --only walks --json bench.json",
                               [&] { return bench_command(line.options); });
  add_seed(command, line);
  add_threads(command, line, "Threads of the scaling row");
  add_isa(command, line);
  command.add_flag("--quick", line.options.quick, "Every row in a few seconds: noisy");
  command.add_option("--only", line.options.only, "A part of it, repeatable (default: all)")
      ->transform(one_of(bench_parts()))
      ->type_name(fmt::format("{}", fmt::join(bench_parts(), "|")))
      ->take_all()
      ->allow_extra_args(false);
  command
      .add_option("--solver-seconds", line.options.solver_seconds,
                  "Seconds of one row of the solver: a finer solution is begun only if it would "
                  "end within them (default: 15, with --quick 0.2)")
      ->transform(positive_number())
      ->type_name("S");
  command
      .add_option("--against", line.options.against,
                  "The --json of an earlier run: ratios row by row, status 1 if a row is slower "
                  "by more than the noise")
      ->transform(named("a file that lamella bench --json wrote"))
      ->type_name("JSON");
  command
      .add_option("--rounds", line.options.rounds,
                  "Measure everything this often, in turn: medians, and their spread as the noise "
                  "(default: 1, with --against 3)")
      ->transform(whole_number(1, 100))
      ->type_name("N");
  add_json(command, line);
  add_html(command, line);
}

void define_samplers(CommandLine& line) {
  CLI::App& command = line.add("samplers", "Variance and largest weight of models' samplers",
                               "lamella samplers --model eon,roughness=1,sampler=cltc --wo 80",
                               [&] { return samplers_command(line.options, line.closed); });
  add_model(command, line, "A model, repeatable (default: EON's and VMF Diffuse's samplers)");
  command
      .add_option("--wo", line.closed.outgoing,
                  "THETA of w_o in degrees, repeatable (default 0 to 89)")
      ->type_name("THETA")
      ->take_all()
      ->allow_extra_args(false);
  command.add_option("--samples", line.closed.samples, "Draws per direction (default 100000)")
      ->transform(whole_number(2, 1000000000000))
      ->type_name("N");
  command.add_flag("--all", line.closed.all,
                   "Of the default models every row, and their times beside the paper's");
  add_seed(command, line);
  add_json(command, line);
}

void define_check(CommandLine& line) {
  CLI::App& command =
      line.add("check", "Values, reciprocity, energy, sampler and density of a model, pass or fail",
               "lamella check eon --quick",
               [&] { return check_command(line.options, line.checking, line.words); });
  command
      .add_option(
          "MODEL", line.words,
          "Model, or shared object (./mine.so), then key=value...: keys that are given stay, "
          "the others vary over their ranges")
      ->transform(named("a model, then key=value..."))
      ->required()
      ->expected(1, -1);
  command.add_flag("--quick", line.options.quick,
                   "5 configurations, 3 angles and 4000 samples: seconds");
  command
      .add_option("--configurations", line.checking.configurations,
                  "Values of the parameters that are tried, at most (default 24)")
      ->transform(whole_number(1, 100000))
      ->type_name("N");
  command
      .add_option("--samples", line.checking.samples,
                  "Draws per direction and configuration (default 20000)")
      ->transform(whole_number(256, 1000000000))
      ->type_name("N");
  command
      .add_option("--time", line.options.seconds,
                  "Seconds after which no further case is begun (default 60)")
      ->transform(positive_number())
      ->type_name("S");
  command
      .add_option("--library", line.checking.library,
                  "Folder of lamella library build: also against the entries that the model claims")
      ->transform(named("a folder of lamella library build"))
      ->type_name("LIBRARY");
  command
      .add_option("--entry", line.checking.entries,
                  "An entry that the model stands for, with the keys to take there, repeatable")
      ->transform(named("NAME[,key=value...]"))
      ->type_name("ENTRY[,key=value...]")
      ->take_all()
      ->allow_extra_args(false);
  add_max_error(command, line);
  add_seed(command, line);
  add_json(command, line);
  add_html(command, line);
}

void define_fit(CommandLine& line) {
  CLI::App& command = line.add(
      "fit", "The parameters of closed forms that come nearest to a stack, lobes or a material",
      "lamella fit vmf_sand --model oren_nayar,eon,vmf_diffuse,lambert_sphere",
      [&] { return fit_command(line.options, line.closed, line.pictures); });
  add_run_options(command, line,
                  "TOML file, - for stdin, built-in stack; with --model also lobes (FILE.exr), a "
                  "measured material (FILE.binary, FILE.bsdf) or a closed form "
                  "(NAME[,key=value...])");
  add_at(command, line);
  add_grid(command, line);
  add_model(command, line,
            "A closed form, repeatable: keys that are given stay, the others are fitted "
            "(key=free: one that is not by itself); NAME,NAME,...: several; all: every one. "
            "Without: SpongeCake's two further lobes, of SGGX mirror flakes and "
            "Henyey-Greenstein layers");
  command
      .add_option("--stack", line.closed.stack,
                  "Instead of --model: a stack whose numbers are fitted, a TOML file or a built-in "
                  "stack")
      ->transform(named(kAllowedStacks))
      ->type_name("STACK");
  command
      .add_option("--vary", line.closed.vary,
                  "With --stack, a number that is free, repeatable: layer.N.KEY (N from 0 at the "
                  "top) or substrate.KEY, =FROM:TO or =FROM:TO:log")
      ->type_name("PATH=RANGE")
      ->take_all()
      ->allow_extra_args(false);
  command
      .add_option("--norm", line.closed.norm,
                  "What is made least: relative RMSE over cells (default), or RMS of ln f")
      ->transform(one_of({"relative", "log"}))
      ->type_name("relative|log");
  command
      .add_option("--sides", line.closed.sides,
                  "Lobes that count: of both sides (default), or reflected alone")
      ->transform(one_of({"all", "reflect"}))
      ->type_name("all|reflect");
  command
      .add_option("--sampling", line.closed.sampling,
                  "Instead: sampling lobes of a closed form with a roughness, as C++")
      ->type_name("NAME[,key=value...]");
  command
      .add_option(
          "-o,--output", line.options.output,
          "A FOLDER with the fit and a comparison's page; of --stack also FILE.toml for the fitted "
          "stack alone; without both a FILE with what was fitted")
      ->transform(named("a folder or file to write"))
      ->type_name("PATH");
  add_pictures(command, line);
}

void define_invert(CommandLine& line) {
  CLI::App& command = line.add("invert", "The single-scattering albedo that gives a colour",
                               "lamella invert vmf_diffuse albedo=0.8,0.4,0.2 roughness=0.5", [&] {
                                 return invert_command(line.options, line.closed, line.words);
                               });
  command
      .add_option(
          "WHAT", line.words,
          "Model, or stack (all its layers get the albedo), then albedo=R,G,B or one number, "
          "the colour as eval MODEL.albedo gives it, or albedo=FILE of a measured material "
          "(.binary, .bsdf), and the model's key=value...")
      ->transform(named("a model or a stack, then key=value..."))
      ->required()
      ->expected(1, -1);
  command
      .add_option("--wi", line.options.incident,
                  "THETA[,PHI] of the light in degrees: the colour is the directional albedo there "
                  "(default 0)")
      ->type_name("THETA[,PHI]");
  command.add_flag("--bond", line.closed.bond, "Light from everywhere instead: the Bond albedo");
  add_walks(command, line, "Walks per evaluation, of a stack");
  add_walk_limits(command, line);
  add_seed(command, line);
  add_threads(command, line);
  add_json(command, line);
}

void define_list(CommandLine& line, const std::string& name, const std::string& doc,
                 const std::string& example, int (*run)(const Options&, const std::string&)) {
  CLI::App& command = line.add(name, doc, "lamella " + name + " " + example,
                               [&line, run] { return run(line.options, line.word); });
  command.add_option("NAME", line.word, "The one to show; without: all there are")
      ->transform(named("a name of the list"));
  add_json(command, line);
}

}  // namespace

void define_model_commands(CommandLine& line) {
  define_eval(line);
  define_tabulate(line);
  define_accuracy(line);
  define_bench(line);
  define_samplers(line);
  define_check(line);
  define_fit(line);
  define_invert(line);
  define_list(line, "models", "The closed forms: parameters, lobes, source", "eon", models_command);
  define_list(line, "media", "The media: keys, ranges, units, source", "sggx", media_command);
  define_list(line, "stacks", "The built-in stacks", "sggx_slab", stacks_command);
}

}  // namespace lamella
