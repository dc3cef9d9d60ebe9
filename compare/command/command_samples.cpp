#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <utility>

#include "compare/command/command.h"
#include "compare/command/divided_run.h"
#include "compare/command/sample_command.h"
#include "compare/files/output_folder.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"
#include "compare/samples/sample_file.h"
#include "phase/math/degrees.h"

namespace lamella {

SampleRequest sample_request(const Options& options, const Stack& stack) {
  const Options usual;
  for (const auto& [found, option] :
       {std::pair(options.estimator != usual.estimator, "--estimator"),
        std::pair(options.tolerance != usual.tolerance, "--tolerance"),
        std::pair(options.grid != usual.grid, "--grid")})
    if (found)
      throw UsageError(fmt::format(
          "{}: found it for walks one by one, which have no use for it; allowed: with --lobes",
          option));
  return SampleRequest(truth_request(options, stack), incident_law_of(options));
}

nlohmann::ordered_json to_json(const SampleTotals& totals, const SampleRequest& request) {
  nlohmann::ordered_json json;
  const int channels = request.plan.channels;
  if (request.law == IncidentLaw::fixed) {
    json["mu_i"] = totals.incident.z;
    json["phi_i"] = phi_degrees(totals.incident);
  }
  json["walks"] = totals.walks;
  json["rows"] = totals.rows;
  const auto add = [&](const char* key, const SampleSums::Channels& sums) {
    json[key] = nlohmann::ordered_json::array();
    for (int c = 0; c < channels; ++c)
      json[key].push_back(sums[c] / static_cast<double>(std::max<std::uint64_t>(totals.walks, 1)));
  };
  add("reflected", totals.sums.reflected);
  add("transmitted", totals.sums.transmitted);
  add("straight", totals.sums.straight);
  add("specular", totals.sums.specular);
  return json;
}

namespace {

void print_totals(std::FILE* out, const SampleTotals& totals, const SampleRequest& request) {
  const int channels = request.plan.channels;
  const auto energy = [&](const SampleSums::Channels& sums) {
    std::string text;
    for (int c = 0; c < channels; ++c)
      text += fmt::format("{}{:.5f}", c ? " " : "",
                          sums[c] / static_cast<double>(std::max<std::uint64_t>(totals.walks, 1)));
    return text;
  };
  if (request.law == IncidentLaw::fixed)
    fmt::print(out, "theta_i {:g}, phi_i {:g}: ", theta_degrees(totals.incident),
               phi_degrees(totals.incident));
  else
    fmt::print(out, "w_i {}: ", to_text(request.law));
  fmt::print(out, "{} walks, {} rows\n", totals.walks, totals.rows);
  fmt::print(out, "  {:<12} {}\n", "reflected", energy(totals.sums.reflected));
  fmt::print(out, "  {:<12} {}\n", "transmitted", energy(totals.sums.transmitted));
  fmt::print(out, "  {:<12} {}\n", "straight", energy(totals.sums.straight));
  if (totals.sums.specular[0] > 0)
    fmt::print(out, "  {:<12} {}\n", "specular", energy(totals.sums.specular));
}

void check_samples(const DividedRun& run) { (void)sample_request(run.options, run.stack); }

void find_samples(const DividedRun& run, const RunMonitor& monitor) {
  (void)stream_samples(sample_request(run.options, run.stack), monitor, [](const SampleChunk&) {});
}

int samples_run(const DividedRun& run, const RunMonitor& monitor) {
  const Options& options = run.options;
  const SampleRequest request = sample_request(options, run.stack);
  if (options.output.empty()) throw UsageError("-o: found nothing; allowed: FILE.npz to write");
  if (!options.output.ends_with(".npz") && !std::filesystem::exists(options.output))
    throw UsageError(fmt::format(
        "-o: found \"{}\"; allowed: a name that ends in .npz, or a folder with --per-bsdf",
        options.output));
  check_output_file(options.output);
  const InputFiles inputs(run.stack);
  const auto start = std::chrono::steady_clock::now();
  SampleFile file(options.output, request.plan.channels);
  const std::vector<SampleTotals> totals =
      stream_samples(request, monitor, [&](const SampleChunk& chunk) { file.add(chunk); });
  inputs.check();
  const std::uint64_t bytes = file.finish(request, totals, inputs);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  std::uint64_t walks = 0, rows = 0;
  nlohmann::ordered_json runs = nlohmann::ordered_json::array();
  for (const SampleTotals& one : totals) {
    walks += one.walks;
    rows += one.rows;
    runs.push_back(to_json(one, request));
  }
  std::FILE* out = table_stream(options);
  if (!options.quiet) {
    fmt::print(out, "{}: walks one by one, sums of weights as fractions of the incident light{}\n",
               run.stack.name, request.plan.channels == 3 ? " (r g b)" : "");
    for (const SampleTotals& one : totals) print_totals(out, one, request);
    if (user_interrupt) fmt::print(out, "interrupted: the walks that were whole until then\n");
    fmt::print(out, "wrote {}: {} walks, {} rows, {} bytes, {:.2f} s\n", options.output, walks,
               rows, bytes, seconds.count());
  }
  nlohmann::ordered_json answer = json_header("samples", request.truth);
  answer["w_i"] = to_text(request.law);
  answer["file"] = options.output;
  answer["walks"] = walks;
  answer["rows"] = rows;
  answer["bytes"] = bytes;
  answer["seconds"] = seconds.count();
  answer["interrupted"] = user_interrupt.load();
  answer["runs"] = std::move(runs);
  add_files(answer, inputs);
  write_json(answer, options.json);
  return kDone;
}

int ranked_samples(const DividedRun& run, const RunMonitor& monitor, Ranks& ranks) {
  return samples_by_ranks(sample_request(run.options, run.stack), monitor, ranks,
                          [&](const RunMonitor& writing) { return samples_run(run, writing); });
}

}  // namespace

const DividedCommand& samples_divided() {
  static const DividedCommand command{"samples",    "FILE.npz",  check_samples,
                                      find_samples, samples_run, ranked_samples};
  return command;
}

int samples_command(const Options& options, const std::vector<std::string>& stacks) {
  if (std::find(stacks.begin(), stacks.end(), "") != stacks.end())
    throw UsageError("STACK: found \"\"; allowed: a TOML file, - for stdin, or a built-in stack");
  if (options.per_bsdf) return sample_set_command(options, stacks);
  for (const auto& [found, name] :
       {std::pair(!options.sets.empty(), "--set"), std::pair(!options.design.empty(), "--design"),
        std::pair(options.lobes, "--lobes")})
    if (found) throw UsageError(fmt::format("{}: found no --per-bsdf; allowed: beside it", name));
  if (stacks.size() > 1)
    throw UsageError(fmt::format("found the stacks \"{}\"; allowed: one, or --per-bsdf",
                                 fmt::join(stacks, "\", \"")));
  Options of_stack = options;
  if (!stacks.empty()) of_stack.stack = stacks[0];
  return do_divided(samples_divided(), {"samples", of_stack, stack_of(of_stack)});
}

}  // namespace lamella
