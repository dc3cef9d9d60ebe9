#include <fmt/format.h>

#include "analytic/model/model.h"
#include "compare/command/command.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/request/truth_request.h"
#include "compare/truth/estimator_choice.h"
#include "compare/truth/pilot.h"
#include "phase/medium/media.h"
#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"
#include "volume/plan/plan.h"
#include "volume/run/explain.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

void print_parameters(std::FILE* out, const std::vector<ParameterInfo>& parameters) {
  for (const ParameterInfo& p : parameters)
    fmt::print(out, "    {:<10} [{}] {}; {}{}\n", p.name, p.unit, p.doc, allowed_values(p),
               p.default_value.empty() ? "" : "; default " + p.default_value);
}

Json to_json(const std::vector<ParameterInfo>& parameters) {
  Json list = Json::array();
  for (const ParameterInfo& p : parameters)
    list.push_back({{"name", p.name},
                    {"unit", p.unit},
                    {"doc", p.doc},
                    {"allowed", allowed_values(p)},
                    {"default", p.default_value}});
  return list;
}

Json list_answer(const std::string& command) { return {{"format", 1}, {"command", command}}; }

}  // namespace

int explain_command(const Options& options) {
  TruthRequest request = truth_request(options, stack_of(options));
  const Stack& stack = request.stack;
  const Plan plan = plan_of(request);
  for (const std::string& warning : plan.warnings) terminal_monitor(options).warn(warning);
  std::FILE* out = table_stream(options);
  Json answer = json_header("explain", request);
  answer["plan"] = Json::array();
  if (!options.quiet) {
    fmt::print(out, "{}\n\n", stack.name);
    std::string toml = to_toml(stack);
    for (std::size_t at = 0; (at = toml.find('\n', at)) != std::string::npos; at += 3)
      toml.replace(at, 1, "\n  ");
    fmt::print(out, "  {}\n", toml);
  }
  const auto add = [&](const PlanNote& note) {
    if (!options.quiet)
      fmt::print(out, "{:<12} {}\n{:<12} because: {}\n", note.subject, note.decision, "",
                 note.reason);
    answer["plan"].push_back(
        {{"subject", note.subject}, {"decision", note.decision}, {"reason", note.reason}});
  };
  for (const PlanNote& note : explain(stack, plan)) add(note);
  if (stack.grains() && !GrainScene::is_available())
    add({"Embree", "missing: simulate, compare and furnace refuse this stack",
         "built with -DLAMELLA_EMBREE=OFF"});
  const RunMonitor monitor = terminal_monitor(options);
  const EstimatorChoice choice =
      choose_estimator(request, Estimator::analog, monitor.stop, monitor.solver);
  if (monitor.finished) monitor.finished();
  add({"estimator", "auto: " + to_text(choice.estimator), choice.reason});
  add({"of walks", "analog for lobes, next-event for furnaces and for truth at points",
       "analog counts every cell at the price of one; a furnace needs an estimate apart from the "
       "ledger"});
  if (!stack.grains() && !stack.has_grid())
    add({"by time", "with --time or --target-error whichever is cheaper for the same error",
         to_text(pilot(request, plan, direction_from_degrees(30, 0))) +
             ", on 16x32 cells from theta_i 30"});
  std::string names;
  for (const ModelInfo& info : models())
    if (info.applies_to && info.applies_to(stack)) names += (names.empty() ? "" : ", ") + info.name;
  add({"models", names.empty() ? "none" : names, "the closed forms that apply to this stack"});
  write_json(answer, options.json);
  return kDone;
}

int models_command(const Options& options) {
  std::FILE* out = table_stream(options);
  Json answer = list_answer("models");
  answer["models"] = Json::array();
  for (const ModelInfo& info : models()) {
    if (!options.quiet) {
      fmt::print(out, "{}: {}\n    source: {}\n", info.name, info.doc, info.source);
      if (info.needs_stack) fmt::print(out, "    stack      a stack file or a built-in stack\n");
      print_parameters(out, info.parameters);
      if (!info.selector.empty())
        fmt::print(out, "    {0}_...   the keys of what {0} names, as they stand there\n",
                   info.selector);
      for (const LobeInfo& lobe : info.lobes)
        fmt::print(out, "    .{:<9} {}; stands for order {}\n", lobe.name, lobe.doc,
                   to_text(lobe.order));
      for (const PartInfo& part : info.parts)
        fmt::print(out, "    .{:<9} {}\n", part.name, part.doc);
    }
    Json lobes = Json::array();
    for (const LobeInfo& lobe : info.lobes)
      lobes.push_back({{"name", lobe.name}, {"doc", lobe.doc}, {"order", to_text(lobe.order)}});
    Json selected = Json::object();
    if (!info.selector.empty())
      for (const std::string& choice : find(info.parameters, info.selector)->choices)
        selected[choice] = to_json(info.selected(choice));
    answer["models"].push_back({{"name", info.name},
                                {"doc", info.doc},
                                {"source", info.source},
                                {"needs_stack", info.needs_stack},
                                {"parameters", to_json(info.parameters)},
                                {"selector", info.selector},
                                {"selected", std::move(selected)},
                                {"lobes", std::move(lobes)}});
  }
  write_json(answer, options.json);
  return kDone;
}

int media_command(const Options& options) {
  std::FILE* out = table_stream(options);
  Json answer = list_answer("media");
  answer["media"] = Json::array();
  for (const MediumInfo& info : media()) {
    if (!options.quiet) {
      fmt::print(out, "{}: {}\n    source: {}\n", info.name, info.doc, info.source);
      print_parameters(out, info.parameters);
    }
    answer["media"].push_back({{"name", info.name},
                               {"doc", info.doc},
                               {"source", info.source},
                               {"parameters", to_json(info.parameters)}});
  }
  for (const GeometryInfo& info : geometries()) {
    if (!options.quiet) {
      fmt::print(out, "{}: {}\n    source: {}\n", info.name, info.doc, info.source);
      print_parameters(out, info.parameters);
    }
    answer["media"].push_back({{"name", info.name},
                               {"doc", info.doc},
                               {"source", info.source},
                               {"parameters", to_json(info.parameters)}});
  }
  if (!options.quiet)
    fmt::print(
        out,
        "sphere_bed, packed_sphere_bed and micrograins are explicit geometry: the only layer of "
        "their stack, with an albedo, but neither density nor an infinite thickness\n"
        "every other layer: albedo [1] a number or [r, g, b] in [0, 1], default 1; thickness [mm], "
        "inf for a half space; density [1/mm], default 1; grid, a .vdb file whose \"density\" "
        "multiplies it from voxel to voxel, with size [mm], two numbers in [1e-06, 1e+06], its "
        "lateral "
        "period, and grid_albedo, \"file\" (default) or \"white\"; of a .vdb file with other "
        "names in it: density_grid, orientation_grid, roughness_grid, albedo_grid, the grids' "
        "names; of one that does not tell its tile: voxels, three whole numbers [x, y, z], and "
        "first_voxel, the index of the lowest one, default [0, 0, 0]\n");
  write_json(answer, options.json);
  return kDone;
}

int stacks_command(const Options& options) {
  std::FILE* out = table_stream(options);
  Json answer = list_answer("stacks");
  answer["stacks"] = Json::array();
  for (const BuiltinStack& stack : builtin_stacks()) {
    if (!options.quiet)
      fmt::print(out, "{:<26} {}\n{:<26} {}\n", stack.name, stack.doc, "", stack.source);
    answer["stacks"].push_back(
        {{"name", stack.name}, {"doc", stack.doc}, {"source", stack.source}, {"toml", stack.toml}});
  }
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
