#include <fmt/format.h>

#include <algorithm>

#include "compare/bench/bench_history.h"
#include "compare/bench/benchmark.h"
#include "compare/command/command.h"
#include "compare/files/output_folder.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/report/report_page.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"
#include "compare/request/percent.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

std::string cell(std::optional<double> x, const char* format) {
  return x ? fmt::format(fmt::runtime(format), *x) : "-";
}

void print_row(std::FILE* out, const BenchmarkRow& row) {
  std::string note = row.baseline;
  if (row.extra.contains("ns_textbook"))
    note += fmt::format(", {:.1f} ns", row.extra["ns_textbook"].get<double>());
  if (row.extra.contains("variance_ratio"))
    note +=
        fmt::format("; cell variance {:.2f} of it", 1 / row.extra["variance_ratio"].get<double>());
  if (row.extra.contains("ratio_to_random"))
    note += fmt::format("; {:.2f} of random walks; closed form {:.1f} ms",
                        row.extra["ratio_to_random"].get<double>(),
                        1e3 * row.extra["closed_seconds"].get<double>());
  if (row.extra.contains("directions_per_second"))
    note += fmt::format(", {:.0f} M directions a second",
                        1e-6 * row.extra["directions_per_second"].get<double>());
  if (row.extra.contains("cycles_per_collision"))
    note += fmt::format("; {:.3g} cycles per collision",
                        row.extra["cycles_per_collision"].get<double>());
  if (row.extra.contains("lane_occupancy"))
    note += fmt::format(", lanes {} occupied, {} of them at null collisions",
                        percent_text(row.extra["lane_occupancy"].get<double>()),
                        percent_text(row.extra["null_collisions"].get<double>()));
  if (row.extra.contains("degree"))
    note += fmt::format("spherical harmonics of degree {}", row.extra["degree"].get<int>());
  else if (row.extra.contains("nodes"))
    note += fmt::format("{}{} nodes, {} modes, {:.2g} MB", note.empty() ? "" : ", ",
                        row.extra["nodes"].get<int>(), row.extra["modes"].get<int>(),
                        1e-6 * row.extra["bytes"].get<double>());
  if (row.extra.contains("exponent"))
    note += fmt::format("{}exponent {:.2f}", note.empty() ? "" : ", ",
                        row.extra["exponent"].get<double>());
  if (row.extra.contains("variance_ratios")) {
    std::string ratios;
    for (const auto& ratio : row.extra["variance_ratios"])
      ratios += fmt::format(" {:.3g}", ratio.get<double>());
    note +=
        fmt::format("; variance ratios{}; slopes {:.2f}, {:.2f}", ratios,
                    row.extra["slope"].get<double>(), row.extra["baseline_slope"].get<double>());
  }
  if (row.extra.contains("longest_walk"))
    note += fmt::format("; longest walks {:.3g} events", row.extra["longest_walk"].get<double>());
  if (row.extra.contains("reached") && !row.extra["reached"].get<bool>()) note += ", not reached";
  if (row.extra.contains("extrapolated") && row.extra["extrapolated"].get<bool>())
    note += note.empty() ? "extrapolated" : ", extrapolated";
  if (row.extra.contains("processor_seconds"))
    note =
        fmt::format("{:.1f} ms of the processor, at least {:.1f} ms on the clock, {} runs",
                    1e3 * row.extra["processor_seconds"].get<double>(),
                    1e3 * row.extra["least_seconds"].get<double>(), row.extra["runs"].get<int>());
  if (row.extra.contains("rays_per_second"))
    note = fmt::format("{:.3g} rays/s among {} spheres; {}",
                       row.extra["rays_per_second"].get<double>(),
                       row.extra["spheres"].get<std::size_t>(), note);
  if (row.extra.contains("bytes") && row.extra.contains("spheres"))
    note = fmt::format("{} spheres, {:.0f} MiB; {}", row.extra["spheres"].get<std::size_t>(),
                       static_cast<double>(row.extra["bytes"].get<std::int64_t>()) / 1048576, note);
  fmt::print(out, "{:<56} {:>9} {:>9} {:>10} {:>8} {:>7}  {}\n", row.what,
             cell(row.seconds, "{:.3g}"), cell(row.collisions_per_second_per_core, "{:.3g}"),
             cell(row.ns_per_eval, "{:.1f}"), cell(row.error, "{:.1e}"),
             cell(row.ratio_to_baseline, "{:.2f}"), note);
  std::fflush(out);
}

// Row by row against the rows of an earlier run; whether one of them is slower now.
bool print_changes(std::FILE* out, const std::vector<BenchChange>& changes) {
  fmt::print(out, "\n{:<56} {:>10} {:>10} {:>7} {:>6}\n", "what", "before", "now", "speed",
             "noise");
  bool fell = false;
  for (const BenchChange& c : changes) {
    fell = fell || c.fell();
    const std::string noise = c.ratio ? percent_text(c.noise) : "-";
    const char* note = c.fell()   ? "slower"
                       : c.rose() ? "faster"
                       : c.ratio  ? ""
                       : !c.now   ? "not measured now"
                                  : "not measured before";
    fmt::print(out, "{:<56} {:>10} {:>10} {:>7} {:>6}  {}\n", c.what, cell(c.before, "{:.3g}"),
               cell(c.now, "{:.3g}"), cell(c.ratio, "{:.2f}"), noise, note);
  }
  return fell;
}

Json to_json(const std::vector<BenchChange>& changes) {
  const auto number = [](std::optional<double> x) { return x ? Json(*x) : Json(); };
  Json list = Json::array();
  for (const BenchChange& c : changes)
    list.push_back({{"what", c.what},
                    {"measure", c.measure},
                    {"before", number(c.before)},
                    {"now", number(c.now)},
                    {"speed_ratio", number(c.ratio)},
                    {"noise", c.ratio ? Json(c.noise) : Json()},
                    {"slower", c.fell()},
                    {"faster", c.rose()}});
  return list;
}

struct BenchPart {
  const char* name;
  std::function<void(const BenchmarkEffort&, std::uint64_t seed, const ReportRow&)> measure;
};
void measure_walks_and_coats(const BenchmarkEffort& effort, std::uint64_t seed,
                             const ReportRow& report) {
  measure_walks(effort, seed, report);
  measure_coats(effort, seed, report);
}
const std::vector<BenchPart>& parts() {
  static const std::vector<BenchPart> list{{"walks", measure_walks_and_coats},
                                           {"tilted", measure_tilted_flakes},
                                           {"samples", measure_samples},
                                           {"mixed", measure_mixed},
                                           {"plan", measure_plan},
                                           {"threads", measure_threads},
                                           {"accuracy", measure_accuracy},
                                           {"roulette", measure_roulette},
                                           {"thinning", measure_thinning},
                                           {"sampling", measure_sampling},
                                           {"order1", measure_order_one},
                                           {"combined", measure_combination},
                                           {"growth", measure_growth_of_walks},
                                           {"solver", measure_deterministic},
                                           {"grids", measure_grids},
                                           {"models", measure_models},
                                           {"tradeoff", measure_tradeoff},
                                           {"grains", measure_grain_tracing},
                                           {"startup", measure_startup}};
  return list;
}

}  // namespace

std::vector<std::string> bench_parts() {
  std::vector<std::string> names;
  for (const BenchPart& part : parts()) names.emplace_back(part.name);
  return names;
}

int bench_command(const Options& options) {
  if (!options.html.empty()) check_output_file(options.html);
  BenchmarkEffort effort = options.quick ? BenchmarkEffort::quick() : BenchmarkEffort{};
  effort.isa = isa_of(options);
  effort.solver_seconds = options.solver_seconds.value_or(effort.solver_seconds);
  std::optional<Json> before;
  try {
    if (!options.against.empty())
      before = read_bench_file(options.against, to_text(effort.isa), options.quick);
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
  const int rounds = options.rounds.value_or(before ? 3 : 1);
  std::FILE* out = table_stream(options);
  if (!options.quiet)
    fmt::print(out, "{:<56} {:>9} {:>9} {:>10} {:>8} {:>7}  {}\n", "what", "seconds", "coll./s",
               "ns/eval", "error", "ratio", "baseline (ratio above 1: faster than it)");
  // Rounds of everything one after the other: a change of the machine's speed meets some rounds of
  // a row and not all.
  std::vector<Json> measured_rows(rounds, Json::array());
  std::vector<std::string> measured;
  for (int round = 0; round < rounds; ++round) {
    if (rounds > 1 && !options.quiet) fmt::print(out, "round {} of {}\n", round + 1, rounds);
    const ReportRow report = [&](const BenchmarkRow& row) {
      if (!options.quiet) print_row(out, row);
      measured_rows[round].push_back(to_json(row));
    };
    for (const BenchPart& part : parts()) {
      const bool wanted =
          options.only.empty() ||
          std::find(options.only.begin(), options.only.end(), part.name) != options.only.end();
      if (!wanted || user_interrupt) continue;
      part.measure(effort, options.seed, report);
      if (round == 0) measured.emplace_back(part.name);
    }
  }
  Json rows = combined_rounds(measured_rows);
  std::vector<BenchChange> changes =
      before ? changes_between(*before, rows) : std::vector<BenchChange>();
  // Of what --only left out nothing is said.
  if (!options.only.empty()) std::erase_if(changes, [](const BenchChange& c) { return !c.now; });
  const bool fell = before && print_changes(out, changes);
  Json answer = json_header("bench", options.seed, isa_of(options));
  answer["quick"] = options.quick;
  answer["solver_seconds"] = effort.solver_seconds;
  answer["parts"] = measured;
  answer["interrupted"] = user_interrupt.load();
  answer["rounds"] = rounds;
  answer["rows"] = std::move(rows);
  if (before) {
    answer["against"] = options.against;
    answer["changes"] = to_json(changes);
  }
  if (!options.html.empty())
    write_report_page(options.html, "Speed against error", answer, nullptr);
  write_json(answer, options.json);
  return fell ? kFailed : kDone;
}

}  // namespace lamella
