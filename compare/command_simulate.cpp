#include <fmt/format.h>

#include "compare/command.h"
#include "compare/json_report.h"
#include "compare/lobe_files.h"
#include "compare/output_folder.h"

namespace lamella {
namespace {

std::string channels_text(const std::array<Estimate, 3>& e, int channels) {
  std::string text;
  for (int c = 0; c < channels; ++c) text += fmt::format("{}{:.5f}", c ? " " : "", e[c].value);
  return text;
}

std::string with_error(const std::array<Estimate, 3>& e, int channels) {
  double error = 0;
  for (int c = 0; c < channels; ++c) error = std::max(error, e[c].standard_error);
  return channels_text(e, channels) + fmt::format(" +- {:.1g}", error);
}

void print_run(std::FILE* out, const RunResult& run) {
  const int channels = run.channels;
  fmt::print(out, "theta_i {:g}, phi_i {:g}: {} walks, {} collisions, {:.2f} s\n",
             theta_degrees(run.incident), phi_degrees(run.incident), run.walks, run.collisions,
             run.seconds);
  for (const bool reflected : {true, false}) {
    const SideResult& side = reflected ? run.reflected : run.transmitted;
    if (!reflected && side.total[0].value == 0 && side.lobes[0].value.empty()) continue;
    fmt::print(out, "  {:<12} {}\n", reflected ? "reflected" : "transmitted",
               with_error(side.total, channels));
    static const char* const names[] = {"order 1", "order 2", "order 3", "order 4+"};
    for (int o = 0; o < kTallyOrders; ++o)
      fmt::print(out, "    {:<10} {}\n", names[o], with_error(side.orders[o], channels));
    if (side.specular[0].value > 0)
      fmt::print(out, "    {:<10} {}\n", "specular", with_error(side.specular, channels));
  }
  fmt::print(out, "  {:<12} {}\n", "uncollided", with_error(run.uncollided, channels));
  fmt::print(out, "  {:<12} {}\n", "absorbed", with_error(run.absorbed, channels));
  fmt::print(out, "  {:<12} {}\n", "unresolved", with_error(run.unresolved, channels));
}

}  // namespace

int simulate_command(const Options& options) {
  const Stack stack = stack_of(options);
  const Plan plan = make_plan(stack, options.max_order);
  const Estimator estimator = estimator_of(options, Estimator::analog);
  if (!options.output.empty()) check_output_file(options.output);
  std::vector<RunResult> runs;
  for (const Direction wi : incident_directions(options, stack)) {
    Simulation simulation(stack, plan, wi, estimator, parse_grid(options.grid), options.seed);
    runs.push_back(
        run_with_progress(simulation, options, fmt::format("theta_i {:g}", theta_degrees(wi))));
    if (interrupted) break;
  }
  std::FILE* out = table_stream(options);
  if (!options.quiet) {
    fmt::print(out, "{}: {} estimator, seed {}, energies as fractions of the incident light{}\n",
               stack.name, to_text(estimator), options.seed, plan.channels == 3 ? " (r g b)" : "");
    for (const RunResult& run : runs) print_run(out, run);
    if (interrupted) fmt::print(out, "interrupted: what was done until then\n");
  }
  if (!options.output.empty()) {
    write_exr(options.output, simulation_image(stack, runs, estimator, options));
    if (!options.quiet) fmt::print(out, "wrote {}\n", options.output);
  }
  nlohmann::ordered_json answer = json_header("simulate", stack, options);
  std::uint64_t collisions = 0;
  double seconds = 0;
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const RunResult& run : runs) {
    collisions += run.collisions;
    seconds += run.seconds;
    list.push_back(to_json(run));
  }
  answer["estimator"] = to_text(estimator);
  answer["walks"] = runs.front().walks;
  answer["collisions"] = collisions;
  answer["seconds"] = seconds;
  answer["interrupted"] = interrupted.load();
  answer["runs"] = std::move(list);
  write_json(answer, options);
  return kDone;
}

}  // namespace lamella
