#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <vector>

#include "compare/command/command.h"
#include "compare/exchange/exported.h"
#include "compare/exchange/lobe_archive.h"
#include "compare/exchange/projected_lobes.h"
#include "compare/files/output_folder.h"
#include "compare/fit/fitted_models.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/report/lobe_files.h"
#include "compare/report/lobe_set.h"
#include "compare/request/errors.h"
#include "compare/request/percent.h"
#include "compare/request/substrate_model.h"
#include "compare/truth/ground_truth.h"
#include "compare/truth/lobe_table.h"
#include "phase/stack/builtin_stacks.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

bool is_stack(const std::string& source) {
  // A closed form may name a stack file at its end.
  if (source == "-" || (source.ends_with(".toml") && source.find(",stack=") == std::string::npos))
    return true;
  const auto& stacks = builtin_stacks();
  return std::any_of(stacks.begin(), stacks.end(),
                     [&](const BuiltinStack& s) { return s.name == source; });
}

// What a SOURCE turned out to be: a stack, or else a closed form.
struct Source {
  std::optional<Stack> stack{};
  std::optional<BoundModel> model{};
};

Source source_of(const Options& options) {
  const std::string& text = options.stack;
  Source source;
  if (is_stack(text)) {
    source.stack = stack_of(options);
    return source;
  }
  ModelRequest request = parse_model_request(text);
  std::optional<Stack> stack;
  for (const auto& [key, value] : request.values)
    if (key == "stack") stack = stack_of(options, value);
  if (!stack) refuse_place(options, text);
  if (stack) std::erase_if(request.values, [](const auto& v) { return v.first == "stack"; });
  source.model =
      bind_model(stack ? with_fitted_lobes(request, *stack) : request, stack ? &*stack : nullptr);
  return source;
}

// The lobes on cells, of whatever SOURCE is.
LobeSet lobes_of(const Source& source, const Options& options, const RunMonitor& monitor) {
  if (options.stack.ends_with(".exr")) return read_lobes(options.stack);
  if (source.model) {
    CellGrid grid = parse_grid(options.grid);
    LobeSet set = projected_lobes(*source.model->model, *source.model->info,
                                  incident_directions(options, Stack{}), grid,
                                  source.model->parameters.has_color() ? 3 : 1);
    set.attributes["lamella.source"] = to_request(*source.model);
    return set;
  }
  const TruthRequest request = truth_request(options, *source.stack);
  GroundTruth truth(request, Estimator::analog, monitor);
  std::vector<RunResult> runs;
  for (std::size_t k = 0; truth.goes_on(k); ++k) runs.push_back(truth.find(k).run);
  LobeSet set = take_lobes(runs);
  set.attributes = file_attributes(
      named_for_image(request, std::filesystem::path(options.output).parent_path()), runs);
  return set;
}

// A stack's reflection between the nodes of a table.
ExportedBrdf brdf_of_stack(const Stack& stack, const Options& options, const RunMonitor& monitor) {
  check_preview("export", stack);
  TruthRequest request = truth_request(options, stack);
  request.effort.walks = std::min(request.effort.walks, kPreviewWalks);
  const auto table =
      std::make_shared<const LobeTable>(LobeTable::make(request, monitor.stop, monitor.solver));
  if (monitor.finished) monitor.finished();
  ExportedBrdf source;
  source.isotropic = !table->has_azimuth();
  source.f = [table](std::span<const DirectionPair> pairs, std::span<Rgb> values) {
    // Pairs of one direction to the viewer come one after the other.
    std::function<Rgb(Direction)> towards;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      if (k == 0 || !(pairs[k].wo == pairs[k - 1].wo)) towards = table->towards(pairs[k].wo);
      values[k] = towards(pairs[k].wi);
    }
  };
  source.description =
      fmt::format("lamella {}: {}, truth by {}", LAMELLA_VERSION, stack.name, table->source());
  if (stack.is_open_below()) source.left_out.emplace_back("transmission");
  if (stack.has_interfaces() && !stack.has_rough_interfaces())
    source.left_out.emplace_back("the smooth interface's mirror image");
  return source;
}

}  // namespace

int export_command(const Options& options, const std::string& format, const std::string& size) {
  const RunMonitor monitor = terminal_monitor(options);
  if (options.output.empty())
    throw UsageError("export -o: found nothing; allowed: a file to write");
  check_output_file(options.output);
  Json answer = json_header("export", options.seed, isa_of(options));
  answer["source"] = options.stack;
  answer["to"] = format;
  answer["file"] = options.output;
  std::FILE* out = table_stream(options);
  if (options.stack.ends_with(".exr")) refuse_place(options, options.stack);
  const Source source = options.stack.ends_with(".exr") ? Source{} : source_of(options);
  const auto brdf_format = parse_brdf_format(format);
  std::string bytes;
  if (!brdf_format) {
    const LobeSet set = lobes_of(source, options, monitor);
    bytes = format == "npz" ? lobe_npz(set) : lobe_csv(set);
  } else if (!source.model && !source.stack) {
    throw UsageError(fmt::format(
        "export --to {}: found {}, lobes on cells of few directions; allowed: npz, csv, or the "
        "stack or model that they come from",
        format, options.stack));
  } else {
    const ExportedBrdf brdf = source.model ? exported_model(*source.model)
                                           : brdf_of_stack(*source.stack, options, monitor);
    for (const std::string& what : brdf.left_out)
      monitor.warn(
          fmt::format("{} holds reflection from above alone: {} is left out", format, what));
    Json sizes = Json::array();
    for (const std::string name : {"small", "medium", "large"}) {
      // MERL has one size.
      if (*brdf_format == BrdfFormat::merl && name != size) continue;
      const std::string written = brdf_bytes(brdf, *brdf_format, tensor_size(name));
      const double error = format_error(brdf, *read_brdf(written, options.output));
      if (!options.quiet)
        fmt::print(out, "{:<8} {:>9} bytes  a reader gets f back within {} (relative RMSE){}\n",
                   *brdf_format == BrdfFormat::merl ? "merl" : name, written.size(),
                   percent_text(error), name == size ? ", written" : "");
      sizes.push_back({{"size", name}, {"bytes", written.size()}, {"relative_rmse", error}});
      if (name == size) bytes = written;
    }
    answer["isotropic"] = brdf.isotropic;
    answer["left_out"] = brdf.left_out;
    answer["sizes"] = std::move(sizes);
  }
  write_file(options.output, bytes);
  answer["bytes"] = bytes.size();
  if (!options.quiet) fmt::print(out, "wrote {}, {} bytes\n", options.output, bytes.size());
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
