#include "compare/report/json_report.h"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include "compare/files/output_folder.h"
#include "phase/math/degrees.h"
#include "phase/stack/stack_paths.h"

namespace lamella {

using Json = nlohmann::ordered_json;

Json json_number(double value) {
  if (std::isfinite(value)) return value;
  return to_text(value);
}

Json to_json(const ParameterValue& value) {
  struct Visitor {
    Json operator()(double x) const { return json_number(x); }
    Json operator()(Rgb c) const {
      if (c.is_grey()) return json_number(c.r);
      return Json::array({c.r, c.g, c.b});
    }
    Json operator()(const std::vector<double>& v) const {
      Json list = Json::array();
      for (const double x : v) list.push_back(json_number(x));
      return list;
    }
    Json operator()(const std::string& s) const { return s; }
  };
  return std::visit(Visitor{}, value);
}

Json to_json(const Stack& stack) {
  Json layers = Json::array();
  for (const Layer& layer : stack.layers) {
    Json entry{{layer.interface ? "interface" : "medium", layer.medium_name}};
    for (const auto& [key, value] : layer.parameters.all()) entry[key] = to_json(value);
    if (layer.interface) {
      layers.push_back(std::move(entry));
      continue;
    }
    entry["albedo"] = to_json(ParameterValue(layer.albedo));
    if (!layer.grains) {
      entry["thickness"] = json_number(layer.thickness);
      entry["density"] = json_number(layer.density);
    }
    if (layer.grid) {
      entry["grid"] = layer.grid->file;
      entry["size"] = {layer.grid->size_x, layer.grid->size_y};
      entry["grid_albedo"] = layer.grid->white ? "white" : "file";
      for (std::size_t k = 0; k < kGridNameKeys.size(); ++k)
        if (!layer.grid->names[k].empty()) entry[kGridNameKeys[k]] = layer.grid->names[k];
      if (layer.grid->voxels) {
        entry["voxels"] = *layer.grid->voxels;
        entry["first_voxel"] = layer.grid->first_voxel;
      }
    }
    layers.push_back(std::move(entry));
  }
  Json out{{"name", stack.name}, {"layer", std::move(layers)}};
  if (stack.substrate && !stack.substrate->model.empty()) {
    Json& substrate = out["substrate"] = {{"bsdf", stack.substrate->model}};
    for (const auto& [key, value] : stack.substrate->parameters.all())
      substrate[key] = to_json(value);
  } else if (stack.substrate)
    out["substrate"] = {{"bsdf", "lambert"},
                        {"albedo", to_json(ParameterValue(stack.substrate->albedo))}};
  return out;
}

Json json_header(const std::string& command, std::uint64_t seed, Isa isa) {
  return {{"format", 1},
          {"command", command},
          {"version", LAMELLA_VERSION},
          {"seed", seed},
          {"threads", tbb::this_task_arena::max_concurrency()},
          {"isa", to_text(isa)}};
}

Json json_header(const std::string& command, const TruthRequest& request) {
  Json header{{"format", 1},
              {"command", command},
              {"version", LAMELLA_VERSION},
              {"stack", to_json(with_files_relative_to(request.stack, ""))}};
  if (!request.texels.empty()) header["texels"] = request.texels.size();
  header.update(json_header(command, request.seed, request.isa));
  return header;
}

void add_files(Json& answer, const InputFiles& inputs) {
  if (!inputs.empty()) answer["files"] = inputs.json("");
}

Json named_for(Json answer, const std::filesystem::path& folder,
               const std::filesystem::path& from) {
  const auto rename = [&](Json& name) {
    GridReference grid;
    grid.file = name.get<std::string>();
    if (is_file(grid)) name = relative_to(from / grid.file, folder).string();
  };
  if (answer.contains("stack") && answer["stack"].contains("layer"))
    for (Json& layer : answer["stack"]["layer"])
      if (layer.contains("grid")) rename(layer["grid"]);
  if (answer.contains("files"))
    for (Json& file : answer["files"]) rename(file["name"]);
  if (answer.contains("points"))
    for (Json& point : answer["points"])
      point["answer"] = named_for(std::move(point["answer"]), folder, from);
  return answer;
}

Json values_of(const std::array<Estimate, 3>& e, int channels) {
  Json list = Json::array();
  for (int c = 0; c < channels; ++c) list.push_back(e[c].value);
  return list;
}

Json errors_of(const std::array<Estimate, 3>& e, int channels) {
  Json list = Json::array();
  for (int c = 0; c < channels; ++c) list.push_back(e[c].standard_error);
  return list;
}

namespace {

bool has_light(const std::array<Estimate, 3>& e) {
  return std::any_of(e.begin(), e.end(), [](const Estimate& x) { return x.value != 0; });
}

Json side_json(const SideResult& side, int channels) {
  Json orders = Json::object();
  static const char* const names[kTallyOrders] = {"1", "2", "3", "4+"};
  const bool has_zero = std::any_of(side.zero.begin(), side.zero.end(),
                                    [](const Estimate& e) { return e.value > 0; });
  if (has_zero)
    orders["0"] = {{"total", values_of(side.zero, channels)},
                   {"standard_error", errors_of(side.zero, channels)}};
  for (int o = 0; o < kTallyOrders; ++o)
    orders[names[o]] = {{"total", values_of(side.orders[o], channels)},
                        {"standard_error", errors_of(side.orders[o], channels)}};
  return {{"total", values_of(side.total, channels)},
          {"standard_error", errors_of(side.total, channels)},
          {"specular", values_of(side.specular, channels)},
          {"multiple",
           {{"total", values_of(side.multiple, channels)},
            {"standard_error", errors_of(side.multiple, channels)}}},
          {"orders", std::move(orders)}};
}

}  // namespace

void add_choice(Json& answer, const EstimatorChoice& choice, const TruthRequest& request) {
  answer["estimator"] = to_text(choice.estimator);
  answer["estimator_asked"] = estimator_asked(request);
  answer["estimator_reason"] = choice.reason;
  if (choice.estimator == Estimator::deterministic) answer["tolerance"] = request.tolerance;
}

Json to_json(const RunResult& run) {
  Json out{{"mu_i", run.incident.z == kGrazingLimit ? 0.0 : run.incident.z},
           {"phi_i", phi_degrees(run.incident)},
           {"walks", run.walks},
           {"collisions", run.collisions},
           {"seconds", run.seconds},
           {"reflected", side_json(run.reflected, run.channels)},
           {"transmitted", side_json(run.transmitted, run.channels)},
           {"uncollided", values_of(run.uncollided, run.channels)},
           {"absorbed", values_of(run.absorbed, run.channels)},
           {"unresolved", values_of(run.unresolved, run.channels)}};
  if (has_loss(run)) {
    out["lost"] = values_of(run.lost, run.channels);
    out["lost_standard_error"] = errors_of(run.lost, run.channels);
  }
  if (const auto& a = run.accuracy)
    out["accuracy"] = {{"reached", a->reached},
                       {"error", json_number(a->error)},
                       {"nodes", a->nodes},
                       {"modes", a->modes},
                       {"bytes", a->bytes}};
  if (run.accuracy && run.accuracy->harmonics)
    out["accuracy"]["harmonics"] = run.accuracy->harmonics;
  if (run.accuracy && run.accuracy->integrated_from)
    out["accuracy"]["integrated_from"] = run.accuracy->integrated_from;
  if (!run.is_bounded()) {
    out["max_order"] = run.max_order;
    out["sampling"] = to_text(run.sampling);
    out["order_1"] = to_text(run.order_one);
  }
  if (run.order_one == OrderOne::exact) out["order_1_p_value"] = run.order_one_p_value;
  if (run.thinning.is_on()) out["thinned_from"] = run.thinning.first;
  if (run.thinning.is_on() || has_light(run.thinned))
    out["thinned"] = values_of(run.thinned, run.channels);
  if (run.holes > 0) out["holes"] = run.holes;
  return out;
}

void write_json(const Json& answer, const std::string& path) {
  if (path.empty()) return;
  if (path == "-")
    fmt::print(stdout, "{}\n", answer.dump(2));
  else
    write_file(path, named_for(answer, std::filesystem::path(path).parent_path()).dump(2) + "\n");
}

}  // namespace lamella
