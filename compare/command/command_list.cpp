#include <fmt/format.h>

#include "analytic/catalogue/model_plugin.h"
#include "analytic/model/model.h"
#include "compare/command/command.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/report/wrapped_text.h"
#include "compare/request/errors.h"
#include "compare/request/truth_request.h"
#include "compare/truth/estimator_choice.h"
#include "compare/truth/pilot.h"
#include "phase/interface/interfaces.h"
#include "phase/medium/media.h"
#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"
#include "volume/plan/plan.h"
#include "volume/run/explain.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// "    name       text", the text below itself.
std::string list_entry(const std::string& name, const std::string& text) {
  return wrapped(fmt::format("    {:<10} ", name), text, 15);
}

void print_parameters(std::FILE* out, const std::vector<ParameterInfo>& parameters) {
  for (const ParameterInfo& p : parameters)
    fmt::print(
        out, "{}",
        list_entry(p.name,
                   fmt::format("[{}] {}; {}{}", p.unit, p.doc, allowed_values(p),
                               p.default_value.empty() ? "" : "; default " + p.default_value)));
}

void print_heading(std::FILE* out, const std::string& name, const std::string& doc,
                   const std::string& source) {
  fmt::print(out, "{}{}", wrapped(name + ": ", doc, 4), wrapped("    source: ", source));
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

// The one entry of that name, or all where there is none. `what`: "model", for the error.
template <class Info>
std::vector<Info> chosen_entries(const std::vector<Info>& all, const std::string& name,
                                 const std::string& what) {
  if (name.empty()) return all;
  std::vector<std::string> names;
  for (const Info& info : all) {
    if (info.name == name) return {info};
    names.push_back(info.name);
  }
  const std::string hint = suggestion(name, names);
  throw UsageError(fmt::format("{} \"{}\": unknown{}; allowed: {}", what, name,
                               hint.empty() ? "" : ", " + hint, listed(names)));
}

// What media and explicit geometry are told by.
struct ListedMedium {
  std::string name, doc, source;
  std::vector<ParameterInfo> parameters;
  std::string entry = "medium";  // or "interface", "substrate": where a stack file has it
};

}  // namespace

int explain_command(const Options& options) {
  TruthRequest request = truth_request(options, stack_of(options));
  const Stack& stack = request.stack;
  const InputFiles inputs(stack);
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
      fmt::print(out, "{}{}", wrapped(fmt::format("{:<12} ", note.subject), note.decision),
                 wrapped(fmt::format("{:<12} because: ", ""), note.reason, 13));
    answer["plan"].push_back(
        {{"subject", note.subject}, {"decision", note.decision}, {"reason", note.reason}});
  };
  for (const PlanNote& note : explain(stack, plan)) add(note);
  if (stack.grains() && !stack.grains()->is_height_field() && !GrainScene::is_available())
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
  inputs.check();
  add_files(answer, inputs);
  add({"models", names.empty() ? "none" : names, "the closed forms that apply to this stack"});
  write_json(answer, options.json);
  return kDone;
}

std::vector<std::string> listed_names(const std::string& command) {
  std::vector<std::string> names;
  if (command == "models")
    for (const ModelInfo& info : models()) names.push_back(info.name);
  if (command == "stacks")
    for (const BuiltinStack& stack : builtin_stacks()) names.push_back(stack.name);
  if (command == "media") {
    for (const MediumInfo& info : media()) names.push_back(info.name);
    for (const GeometryInfo& info : geometries()) names.push_back(info.name);
    for (const InterfaceInfo& info : interfaces()) names.push_back(info.name);
    names.push_back(kConductor);
  }
  return names;
}

int models_command(const Options& options, const std::string& name) {
  std::FILE* out = table_stream(options);
  Json answer = list_answer("models");
  answer["models"] = Json::array();
  const std::vector<ModelInfo> list = is_plugin_path(name)
                                          ? std::vector{load_model_plugin(name)}
                                          : chosen_entries(models(), name, "model");
  for (const ModelInfo& info : list) {
    if (!options.quiet) {
      print_heading(out, info.name, info.doc, info.source);
      if (info.needs_stack)
        fmt::print(out, "{}", list_entry("stack", "a stack file or a built-in stack"));
      print_parameters(out, info.parameters);
      if (!info.selector.empty())
        fmt::print(out, "    {}KEY   the keys of what {} names, as they stand there\n",
                   info.selected_prefix, info.selector);
      for (const LobeInfo& lobe : info.lobes)
        fmt::print(
            out, "{}",
            list_entry("." + lobe.name, lobe.doc + "; stands for order " + to_text(lobe.order)));
      for (const PartInfo& part : info.parts)
        fmt::print(out, "{}", list_entry("." + part.name, part.doc));
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

int media_command(const Options& options, const std::string& name) {
  std::FILE* out = table_stream(options);
  Json answer = list_answer("media");
  answer["media"] = Json::array();
  std::vector<ListedMedium> all;
  for (const MediumInfo& info : media())
    all.push_back({info.name, info.doc, info.source, info.parameters});
  for (const GeometryInfo& info : geometries())
    all.push_back({info.name, info.doc, info.source, info.parameters});
  for (const InterfaceInfo& info : interfaces())
    all.push_back({info.name, info.doc, info.source, info.parameters, "interface"});
  all.push_back({kConductor, "smooth or rough metal as a substrate", "Born and Wolf; Walter 2007",
                 conductor_parameters(), "substrate"});
  for (const ListedMedium& info : chosen_entries(all, name, "medium")) {
    if (!options.quiet) {
      print_heading(out, info.name,
                    info.entry == "medium" ? info.doc : info.entry + ": " + info.doc, info.source);
      print_parameters(out, info.parameters);
    }
    answer["media"].push_back({{"name", info.name},
                               {"entry", info.entry},
                               {"doc", info.doc},
                               {"source", info.source},
                               {"parameters", to_json(info.parameters)}});
  }
  if (!options.quiet && (name.empty() || find_geometry(name)))
    fmt::print(out, "{}",
               wrapped("",
                       "sphere_bed, packed_sphere_bed and micrograins are explicit geometry: "
                       "the only layer of their stack, with an albedo, but neither density nor "
                       "an infinite thickness"));
  if (!options.quiet && (name.empty() || find_medium(name)))
    fmt::print(
        out, "{}",
        wrapped(name.empty() ? "every other layer: " : "a layer also has ",
                "albedo [1] a number or [r, g, b] in [0, 1], default 1; thickness [mm], inf "
                "for a half space; density [1/mm], default 1; grid, a .vdb file whose "
                "\"density\" multiplies it from voxel to voxel, with size [mm], two "
                "numbers in [1e-06, 1e+06], its lateral period, and grid_albedo, \"file\" "
                "(default) or \"white\"; of a .vdb file with other names in it: density_grid, "
                "orientation_grid, roughness_grid, albedo_grid, the grids' names; of one "
                "that does not tell its tile: voxels, three whole numbers [x, y, z], and "
                "first_voxel, the index of the lowest one, default [0, 0, 0]",
                0));
  write_json(answer, options.json);
  return kDone;
}

int stacks_command(const Options& options, const std::string& name) {
  std::FILE* out = table_stream(options);
  Json answer = list_answer("stacks");
  answer["stacks"] = Json::array();
  for (const BuiltinStack& stack : chosen_entries(builtin_stacks(), name, "stack")) {
    if (!options.quiet)
      fmt::print(out, "{}{}", wrapped(fmt::format("{:<26} ", stack.name), stack.doc),
                 wrapped(std::string(27, ' '), stack.source));
    if (!options.quiet && !name.empty()) fmt::print(out, "\n{}", stack.toml);
    answer["stacks"].push_back(
        {{"name", stack.name}, {"doc", stack.doc}, {"source", stack.source}, {"toml", stack.toml}});
  }
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
