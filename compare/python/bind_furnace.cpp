#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <nlohmann/json.hpp>

#include "compare/command/command.h"
#include "compare/judge/model_furnace.h"
#include "compare/python/bindings.h"
#include "compare/python/bound_model.h"
#include "compare/python/keyword_options.h"
#include "compare/python/work.h"
#include "phase/math/degrees.h"

namespace lamella {

namespace py = pybind11;

namespace {

using Json = nlohmann::ordered_json;

// What a true furnace of a closed form may miss of the energy, unless something else is asked for.
constexpr double kModelTolerance = 1e-3;

// The command's answer as JSON, and the warnings. `model`: text as --model has it, or empty.
py::tuple furnace(const Stack& stack, const std::string& model, const py::dict& keywords,
                  const py::object& show) {
  Options options = options_of(keywords);
  if (!model.empty()) options.models = {model};
  std::string answer;
  WorkEnd end = do_work(options.threads, show, [&](const RunMonitor& monitor) {
    answer = furnace_answer(options, stack, monitor).json.dump();
  });
  return py::make_tuple(answer, end.warnings);
}

// The furnace of a model as it is: what it is made of nobody can set to 1.
std::string model_furnace(const PythonModel& model, const py::dict& keywords) {
  const Options options = options_of(keywords);
  const double tolerance = options.max_error.value_or(kModelTolerance);
  Json answer{{"format", 1}, {"command", "furnace"}, {"tolerance", tolerance}},
      runs = Json::array();
  FurnaceVerdict worst = FurnaceVerdict::pass;
  do_whole_work([&](const RunMonitor& monitor) {
    for (const Direction wi : incident_directions(options, Stack{})) {
      if (monitor.is_stopped()) return;
      const ModelFurnace f = judge_model_furnace(*model.bound.model, wi, options.as_is, tolerance);
      if (worst != FurnaceVerdict::fail && f.verdict != FurnaceVerdict::pass) worst = f.verdict;
      Json energy = Json::array(), error = Json::array();
      for (int c = 0; c < model.channels; ++c) {
        energy.push_back(f.energy[c]);
        error.push_back(f.error[c]);
      }
      runs.push_back({{"mu_i", wi.z},
                      {"phi_i", phi_degrees(wi)},
                      {"energy", energy},
                      {"energy_error", error},
                      {"ended_by", to_text(f.end)},
                      {"verdict", to_text(f.verdict)},
                      {"loss_or_gain", loss_or_gain(f.loses, f.gains)}});
    }
  });
  answer["verdict"] = to_text(worst);
  answer["runs"] = std::move(runs);
  return answer.dump();
}

}  // namespace

void bind_furnace(py::module_& m) {
  m.def("furnace", &furnace);
  m.def("model_furnace", &model_furnace);
}

}  // namespace lamella
