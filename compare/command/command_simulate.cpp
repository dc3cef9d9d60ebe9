#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "compare/command/command.h"
#include "compare/command/divided_run.h"
#include "compare/files/output_folder.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/report/lobe_files.h"
#include "compare/report/map_error.h"
#include "compare/report/texel_record.h"
#include "compare/request/interrupt.h"
#include "compare/request/truth_request.h"
#include "compare/truth/ground_truth.h"
#include "phase/math/degrees.h"

namespace lamella {
namespace {

std::string with_error(const std::array<Estimate, 3>& e, const RunResult& run) {
  double error = 0;
  std::string text;
  for (int c = 0; c < run.channels; ++c) {
    error = std::max(error, e[c].standard_error);
    text += fmt::format("{}{:.{}f}", c ? " " : "", e[c].value, run.is_bounded() ? 9 : 5);
  }
  return text + fmt::format(" +- {:.1g}", error);
}

std::string cost_of(const RunResult& run) {
  if (!run.is_bounded()) return fmt::format("{} walks, {} collisions", run.walks, run.collisions);
  const DeterministicAccuracy& a = *run.accuracy;
  if (a.harmonics)
    return fmt::format("harmonics of degree {}, cells within {:.1e}", a.harmonics, a.error);
  return fmt::format("{} nodes, {} modes, cells within {:.1e}", a.nodes, a.modes, a.error);
}

void print_run(std::FILE* out, const RunResult& run) {
  fmt::print(out, "theta_i {:g}, phi_i {:g}: {}, {:.2f} s\n", theta_degrees(run.incident),
             phi_degrees(run.incident), cost_of(run), run.seconds);
  for (const bool reflected : {true, false}) {
    const SideResult& side = reflected ? run.reflected : run.transmitted;
    // The solver leaves less than its rounding at the bottom of a half space.
    if (!reflected && side.total[0].value < 1e-12 && side.lobes[0].value.empty()) continue;
    fmt::print(out, "  {:<12} {}\n", reflected ? "reflected" : "transmitted",
               with_error(side.total, run));
    if (side.zero[0].value > 0)
      fmt::print(out, "    {:<10} {}\n", "order 0", with_error(side.zero, run));
    static const char* const names[] = {"order 1", "order 2", "order 3", "order 4+"};
    for (int o = 0; o < kTallyOrders; ++o)
      fmt::print(out, "    {:<10} {}\n", names[o], with_error(side.orders[o], run));
    if (side.specular[0].value > 0)
      fmt::print(out, "    {:<10} {}\n", "specular", with_error(side.specular, run));
  }
  fmt::print(out, "  {:<12} {}\n", "uncollided", with_error(run.uncollided, run));
  fmt::print(out, "  {:<12} {}\n", "absorbed", with_error(run.absorbed, run));
  if (has_loss(run)) fmt::print(out, "  {:<12} {}\n", "lost", with_error(run.lost, run));
  fmt::print(out, "  {:<12} {}\n", "unresolved", with_error(run.unresolved, run));
  if (run.thinning.is_on())
    fmt::print(out,
               "  {:<12} {}: from the {}th event on half of the walks end, the others count "
               "double\n",
               "thinned", with_error(run.thinned, run), run.thinning.first);
  else if (std::any_of(run.thinned.begin(), run.thinned.end(),
                       [](const Estimate& e) { return e.value != 0; }))
    fmt::print(out, "  {:<12} {}: taken by roulette on forced flights, less what it gave: noise\n",
               "thinned", with_error(run.thinned, run));
  if (run.order_one == OrderOne::exact)
    fmt::print(out, "  {:<12} exact; what walks counted of it has p = {:.2g}\n", "order 1",
               run.order_one_p_value);
  if (run.holes > 0)
    fmt::print(out, "  {:<12} {} rays began inside of a grain: please report it\n", "holes",
               run.holes);
}

int simulate_run(const DividedRun& run_of, const RunMonitor& monitor) {
  const Options& options = run_of.options;
  const TruthRequest request = request_of(run_of);
  const InputFiles inputs(request.stack);
  const Stack& stack = request.stack;
  GroundTruth truth(request, Estimator::analog, monitor);
  if (!options.output.empty()) check_output_file(options.output);
  std::vector<RunResult> runs, map_errors;
  for (std::size_t k = 0; truth.goes_on(k); ++k) {
    Truth found = truth.find(k);
    runs.push_back(std::move(found.run));
    if (found.map_error) map_errors.push_back(std::move(*found.map_error));
  }
  inputs.check();
  std::FILE* out = table_stream(options);
  if (!options.quiet) {
    fmt::print(out, "{}: {}, energies as fractions of the incident light{}\n", stack.name,
               estimator_text(truth.choice(), request),
               truth.plan().channels == 3 ? " (r g b)" : "");
    for (std::size_t k = 0; k < runs.size(); ++k) {
      print_run(out, runs[k]);
      if (!map_errors.empty()) fmt::print(out, "{}", map_error_text(map_errors[k], 2));
    }
    if (user_interrupt) fmt::print(out, "interrupted: what was done until then\n");
  }
  if (!options.output.empty()) {
    const auto folder = std::filesystem::path(options.output).parent_path();
    ExrImage image = simulation_image(named_for_image(request, folder), runs);
    add_map_errors(image, map_errors);
    record_texels(image, request, truth.texel_ends());
    record_files(image, inputs, folder);
    write_exr(options.output, image);
    if (!options.quiet) fmt::print(out, "wrote {}\n", options.output);
  }
  nlohmann::ordered_json answer = json_header("simulate", request);
  std::uint64_t collisions = 0;
  double seconds = 0;
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const RunResult& run : runs) {
    collisions += run.collisions;
    seconds += run.seconds;
    list.push_back(to_json(run));
    if (!map_errors.empty()) list.back()["map_error"] = map_error_json(map_errors[list.size() - 1]);
  }
  add_choice(answer, truth.choice(), request);
  answer["walks"] = runs.front().walks;
  answer["collisions"] = collisions;
  answer["seconds"] = seconds;
  answer["interrupted"] = user_interrupt.load();
  answer["runs"] = std::move(list);
  add_files(answer, inputs);
  write_json(answer, options.json);
  return kDone;
}

}  // namespace

const DividedCommand& simulate_divided() {
  static const DividedCommand command{
      "simulate", "FILE.exr",
      [](const DividedRun& run) { check_walks_are_given(truth_request(run.options, run.stack)); },
      find_truths, simulate_run};
  return command;
}

int simulate_command(const Options& options) {
  StackOrMean found = stack_or_mean_of(options);
  return do_divided(simulate_divided(), {.command = "simulate",
                                         .options = options,
                                         .stack = std::move(found.stack),
                                         .texels = std::move(found.texels)});
}

}  // namespace lamella
