#include "compare/command_line/option_definitions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <limits>

#include "compare/drawing/picture_format.h"
#include "compare/files/output_folder.h"
#include "compare/request/errors.h"
#include "compare/request/model_file.h"
#include "compare/request/numbers.h"
#include "compare/shards/job_array.h"
#include "phase/stack/stack_file.h"

namespace lamella {

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

CLI::Validator power_of_two_or_none() {
  static constexpr std::uint64_t kMost = 1 << 20;
  return {[](std::string& text) {
            const auto value = parse_whole_number(text);
            if (!value || *value > kMost || (*value & (*value - 1)) != 0)
              return fmt::format("found \"{}\"; allowed: 0, or a power of two up to {}", text,
                                 kMost);
            text = fmt::format("{}", *value);
            return std::string();
          },
          ""};
}

CLI::Validator one_part() {
  return {[](std::string& text) {
            try {
              (void)shard_from(text, process_environment());
            } catch (const UsageError& error) {
              // The parser puts the option's name before it.
              const std::string reason = error.what();
              return reason.substr(reason.find("found"));
            }
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

CLI::Validator named(const std::string& allowed) {
  return {[allowed](std::string& text) {
            return text.empty() ? fmt::format("found \"\"; allowed: {}", allowed) : std::string();
          },
          ""};
}

CLI::Validator model_argument() {
  return {[](std::string& text) {
            try {
              text = model_text(text);
            } catch (const UsageError& error) {
              return std::string(error.what());
            }
            return std::string();
          },
          ""};
}

namespace {

// The endings of formats that the program reads or writes, and of pictures and texts that it might
// be taken to write.
const std::vector<std::string>& known_endings() {
  static const std::vector<std::string> endings{".exr", ".png",  ".json", ".html", ".toml", ".vdb",
                                                ".csv", ".txt",  ".pdf",  ".svg",  ".jpg",  ".jpeg",
                                                ".tif", ".tiff", ".hdr",  ".npz",  ".so"};
  return endings;
}

std::string ending_of(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

bool is_known(const std::string& ending) {
  const auto& known = known_endings();
  return std::find(known.begin(), known.end(), ending) != known.end();
}

}  // namespace

CLI::Validator output_of(const std::string& type) {
  return {[type](std::string& text) -> std::string {
            const std::filesystem::path path = text;
            const std::string ending = ending_of(path);
            if (type == "FILE" && text == "-") return "";
            const auto found = [&](const std::string& allowed) {
              return fmt::format("found \"{}\"; allowed: {}", text, allowed);
            };
            if (text.empty()) return found("a name");
            if (type == "FILE.npz|FOLDER" && ending != ".npz") {
              if (std::filesystem::is_directory(path) ||
                  (!is_known(ending) && !std::filesystem::is_regular_file(path)))
                return "";
              return found("a name that ends in .npz, or a folder");
            }
            if (type == "FOLDER") {
              if (!is_known(ending) || std::filesystem::exists(path)) return "";
              return found(fmt::format("a folder, whose name does not end in {}", ending));
            }
            check_output_file(path);
            if (std::filesystem::exists(path) && !std::filesystem::is_regular_file(path)) return "";
            const std::size_t dot = type.find('.');
            if (dot == std::string::npos)
              return is_known(ending) && ending != ".json" && ending != ".toml" && ending != ".txt"
                         ? found("a name that does not end in " + ending)
                         : "";
            const std::string own = type.substr(dot, type.find('|') - dot);
            return ending == own ? "" : found("a name that ends in " + own);
          },
          ""};
}

void add_stack(CLI::App& command, CommandLine& line) {
  command
      .add_option("STACK", line.options.stack,
                  "TOML file, - for stdin, or a built-in stack (lamella stacks)")
      ->transform(named(kAllowedStacks));
  add_at(command, line);
}

void add_at(CLI::App& command, CommandLine& line) {
  command
      .add_option(
          "--at", line.options.at,
          "The place on a stack with pictures among its values, u and v from 0 to 1; "
          "simulate, compare, furnace, preview without --shape: or mean, over the whole picture")
      ->transform(named("U,V or mean"))
      ->type_name("U,V");
}

void add_json(CLI::App& command, CommandLine& line) {
  command.add_option("--json", line.options.json, "Write the answer as JSON to FILE, - for stdout")
      ->transform(output_of("FILE"))
      ->type_name("FILE");
  command.add_flag("--quiet", line.options.quiet, "No table, no progress");
}

void add_html(CLI::App& command, CommandLine& line) {
  command.add_option("--html", line.options.html, "Write the answer as a page to look at")
      ->transform(output_of("FILE.html"))
      ->type_name("FILE.html");
}

void add_walks(CLI::App& command, CommandLine& line, const std::string& doc,
               std::uint64_t standard) {
  command.add_option("--walks", line.walks, fmt::format("{} (default {})", doc, standard))
      ->transform(whole_number(kBatches, 1000000000000000))
      ->type_name("N");
}

void add_walk_limits(CLI::App& command, CommandLine& line, bool counted) {
  command
      .add_option("--max-order", line.options.max_order,
                  fmt::format("Walks beyond it are cut and reported as unresolved (default {}, or "
                              "{} where they are thinned)",
                              kMaxOrder, kThinnedMaxOrder))
      ->transform(whole_number(1, std::uint64_t{1} << 62))
      ->type_name("K");
  command
      .add_option(
          "--thin-from", line.options.thin_from,
          "Thin long walks: after K events, a power of two, and every fourfold of that half "
          "of them end, and the others count double; 0: never (default: 16 or later where "
          "that pays, see explain)")
      ->transform(power_of_two_or_none())
      ->type_name("K");
  command.add_flag("--walk-order-1", line.options.walk_order_1,
                   "All orders by walks; else order 1 is exact where it has a closed form that "
                   "takes less time than the walks, which count it as a check (explain says)");
  if (!counted) return;
  command
      .add_option("--sampling", line.options.sampling,
                  "Numbers of a walk's first steps, on lanes, in density grids and among grains: "
                  "points of randomly shifted lattices, which lower the noise, or random (default "
                  "rqmc)")
      ->transform(one_of({"rqmc", "random"}))
      ->type_name("rqmc|random");
}

void add_tolerance(CLI::App& command, CommandLine& line) {
  command
      .add_option(
          "--tolerance", line.options.tolerance,
          "Largest error of the deterministic solver, relative to the mean over the azimuth "
          "(default 1e-4, which takes about a second; 1e-6 and 1e-8 take longer)")
      ->transform(positive_number())
      ->type_name("E");
}

void add_estimator(CLI::App& command, CommandLine& line) {
  command.add_option("--estimator", line.options.estimator, "How light is counted (default auto)")
      ->transform(one_of({"auto", "analog", "next-event", "deterministic"}))
      ->type_name("auto|analog|next-event|deterministic");
  add_tolerance(command, line);
}

void add_seed(CLI::App& command, CommandLine& line) {
  command.add_option("--seed", line.options.seed, "Seed of the random numbers (default 1)")
      ->transform(whole_number(0, std::numeric_limits<std::uint64_t>::max()))
      ->type_name("N");
}

void add_threads(CLI::App& command, CommandLine& line, const std::string& doc) {
  command.add_option("--threads", line.options.threads, doc + " (default: all)")
      ->transform(whole_number(1, 4096))
      ->type_name("N");
}

void add_isa(CLI::App& command, CommandLine& line) {
  command
      .add_option(
          "--isa", line.options.isa,
          "Instruction set of the kernels (default auto: the widest of the machine, or what "
          "LAMELLA_ISA names)")
      ->transform(one_of({"auto", "scalar", "sse4", "avx2", "avx512"}))
      ->type_name("auto|scalar|sse4|avx2|avx512");
}

void add_grid(CLI::App& command, CommandLine& line) {
  command.add_option("--grid", line.options.grid, "Cells per hemisphere (default 16x32)")
      ->type_name("MUxPHI");
}

void add_model(CLI::App& command, CommandLine& line, const std::string& doc) {
  command.add_option("--model", line.options.models, doc + "; @FILE: as it stands there")
      ->transform(model_argument())
      ->type_name("NAME[,key=value...]")
      ->take_all()
      ->allow_extra_args(false);
}

void add_max_error(CLI::App& command, CommandLine& line) {
  command
      .add_option("--max-error", line.options.max_error,
                  "Exit 1 if a model is farther off than this (see README)")
      ->transform(number_from_zero())
      ->type_name("E");
}

void add_pictures(CLI::App& command, CommandLine& line) {
  command
      .add_option("--pictures", line.pictures,
                  "Formats of pictures and charts, with commas between them (default png)")
      ->delimiter(',')
      ->transform(one_of(picture_format_names()))
      ->type_name("png,svg,pdf");
}

void add_output(CLI::App& command, CommandLine& line, const std::string& type,
                const std::string& doc) {
  command.add_option("-o,--output", line.options.output, doc)
      ->transform(output_of(type))
      ->type_name(type);
}

void add_shard(CLI::App& command, CommandLine& line, const std::string& type,
               const std::string& doc) {
  command
      .add_option(
          "--shard", line.options.shard,
          "Do the part I of N parts, from 1 (see lamella merge); auto, auto/N: of a job array")
      ->transform(one_part())
      ->type_name("I/N");
  const CLI::Validator own = output_of(type.empty() ? "FILE.part" : type);
  command
      .add_option("-o,--output", line.options.output,
                  (doc.empty() ? "" : doc + "; ") + "with --shard: the part, FILE.part")
      ->transform(CLI::Validator(
          [own](std::string& text) -> std::string {
            if (!text.ends_with(".part")) return own(text);
            check_output_file(text);
            return "";
          },
          ""))
      ->type_name(type.empty() ? "FILE.part" : type);
}

void add_checkpoint(CLI::App& command, CommandLine& line) {
  command
      .add_option("--checkpoint", line.options.checkpoint,
                  "Keep what is done in FILE, every minute and where the run is interrupted; the "
                  "same command goes on from there")
      ->transform(CLI::Validator(
          [own = output_of("FILE")](std::string& text) -> std::string {
            if (text == "-" ||
                (std::filesystem::exists(text) && !std::filesystem::is_regular_file(text) &&
                 !std::filesystem::is_directory(text)))
              return fmt::format("found \"{}\"; allowed: a file", text);
            return own(text);
          },
          ""))
      ->type_name("FILE");
  command
      .add_option("--checkpoint-every", line.options.checkpoint_every,
                  "Seconds between two of them (default 60)")
      ->transform(positive_number())
      ->type_name("S");
}

void add_incident(CLI::App& command, CommandLine& line) {
  command
      .add_option("--wi", line.options.incident,
                  "Incident direction THETA[,PHI] in degrees, repeatable; above 90: from below "
                  "(default 0, 30, 60, 80)")
      ->type_name("THETA[,PHI]")
      ->take_all()
      ->allow_extra_args(false);
}

void add_run_options(CLI::App& command, CommandLine& line, const std::string& target) {
  if (target.empty())
    add_stack(command, line);
  else
    command.add_option("TARGET", line.options.stack, target)->transform(named(kAllowedStacks));
  add_incident(command, line);
  add_walks(command, line, "Walks per incident direction");
  command
      .add_option("--target-error", line.options.target_error,
                  "Stop at this largest relative standard error of the lobe energies above 1e-3")
      ->transform(positive_number())
      ->type_name("E");
  command
      .add_option("--time", line.options.seconds,
                  "Stop after S seconds per incident direction; the solver: in all")
      ->transform(positive_number())
      ->type_name("S");
  add_walk_limits(command, line, target.empty());  // fit has a --sampling of its own
  add_estimator(command, line);
  add_seed(command, line);
  add_threads(command, line);
  add_isa(command, line);
  add_json(command, line);
}

}  // namespace lamella
