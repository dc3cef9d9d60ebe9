#include <pybind11/stl.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <variant>

#include "compare/fit/least_squares.h"
#include "compare/nearest/held_out.h"
#include "compare/nearest/nearest_models.h"
#include "compare/nearest/stack_fit.h"
#include "compare/python/bindings.h"
#include "compare/python/bound_model.h"
#include "compare/python/keyword_options.h"
#include "compare/python/python_family.h"
#include "compare/python/python_lobes.h"
#include "compare/python/python_report.h"
#include "compare/python/work.h"
#include "compare/report/json_report.h"
#include "compare/request/errors.h"
#include "compare/request/model_file.h"

namespace lamella {

namespace py = pybind11;

namespace {

// Fits, and all that they point to.
struct PythonFits {
  std::shared_ptr<PythonModel> given;  // the target, or none
  std::vector<std::shared_ptr<const ModelInfo>> families;
  InputFiles inputs;
  TargetTruths target;
  NearestModels nearest;

  [[nodiscard]] nlohmann::ordered_json answer() const {
    nlohmann::ordered_json json = fit_json(target, nearest);
    add_files(json, inputs);
    return json;
  }
};

// `others`: directions in the place of those of the options; lobes have their own alone.
TargetTruths target_of(const PythonLobes* lobes, const PythonModel* model, const Stack* stack,
                       const Options& options, const RunMonitor& monitor,
                       const std::vector<Direction>& others = {}) {
  const auto along = [&](TruthRequest request) {
    if (!others.empty()) request.directions = others;
    return request;
  };
  if (lobes) {
    TargetTruths found = truths_of(lobes->set, "lobes");
    found.request.isa = isa_of(options);
    return found;
  }
  if (model) {
    TruthRequest request;
    request.stack.name = model->bound.info->name;
    request.directions = incident_directions(options, Stack{});
    request.cells = parse_grid(options.grid);
    request.isa = isa_of(options);
    return truths_of(*model->bound.model, *model->bound.info, model->channels, along(request),
                     monitor);
  }
  GroundTruth truth(along(truth_request(options, *stack)), Estimator::analog, monitor);
  return truths_of(truth);
}

// The fits and the warnings. `target`: a Stack, Lobes or a Model; `models`: texts and families.
py::tuple fit(const py::object& target, const std::vector<py::object>& models,
              const std::string& norm, const std::string& sides, const py::dict& keywords,
              const py::object& show) {
  require_least_squares();
  const Options options = options_of(keywords);
  auto fits = std::make_unique<PythonFits>();
  std::vector<std::variant<ModelRequest, const ModelInfo*>> asked;
  std::vector<ModelRequest> requests;
  for (const py::object& model : models) {
    if (py::isinstance<py::str>(model)) {
      for (ModelRequest& request : models_to_fit({model_text(py::cast<std::string>(model))})) {
        requests.push_back(request);
        asked.emplace_back(std::move(request));
      }
      continue;
    }
    fits->families.push_back(py::cast<const PythonFamily&>(model).info);
    asked.emplace_back(fits->families.back().get());
  }
  (void)parametric_models(requests, 1);
  const PythonLobes* lobes =
      py::isinstance<PythonLobes>(target) ? py::cast<const PythonLobes*>(target) : nullptr;
  if (py::isinstance<PythonModel>(target))
    fits->given = py::cast<std::shared_ptr<PythonModel>>(target);
  const Stack* stack = !lobes && !fits->given ? &py::cast<const Stack&>(target) : nullptr;
  WorkEnd end = do_work(options.threads, show, [&](const RunMonitor& monitor) {
    fits->inputs = InputFiles(stack ? *stack : Stack{}, objects_among(requests));
    fits->target = target_of(lobes, fits->given.get(), stack, options, monitor);
    std::vector<ParametricModel> parametric;
    for (const auto& one : asked) {
      const ModelInfo* const* info = std::get_if<const ModelInfo*>(&one);
      const int channels = fits->target.plan.channels;
      if (info)
        parametric.push_back(parametric_model(**info, {(*info)->name, {}}, channels));
      else
        parametric.push_back(parametric_models({std::get<ModelRequest>(one)}, channels).front());
    }
    fits->nearest = nearest_models(fits->target, parametric,
                                   norm == "log" ? FitNorm::logarithmic : FitNorm::relative,
                                   sides == "reflect" ? FitSides::reflect : FitSides::all, monitor);
    if (!lobes && !monitor.is_stopped())
      if (const auto others = held_out_directions(fits->target.request.directions); !others.empty())
        judge_held_out(fits->nearest,
                       target_of(lobes, fits->given.get(), stack, options, monitor, others));
    fits->inputs.check();
  });
  return py::make_tuple(std::move(fits), end.warnings);
}

// The numbers of a stack instead of models; the target is a Stack, Lobes or a Model.
py::tuple fit_stack(const py::object& target, const Stack& stack,
                    const std::vector<std::string>& vary, const std::string& norm,
                    const std::string& sides, const py::dict& keywords, const py::object& show) {
  require_least_squares();
  const Options options = options_of(keywords);
  (void)parametric_stack(stack, vary, 1);
  auto fits = std::make_unique<PythonFits>();
  const PythonLobes* lobes =
      py::isinstance<PythonLobes>(target) ? py::cast<const PythonLobes*>(target) : nullptr;
  if (py::isinstance<PythonModel>(target))
    fits->given = py::cast<std::shared_ptr<PythonModel>>(target);
  const Stack* of = !lobes && !fits->given ? &py::cast<const Stack&>(target) : nullptr;
  Options how = options;
  how.incident.clear();
  const TruthRequest request = truth_request(how, stack);
  WorkEnd end = do_work(options.threads, show, [&](const RunMonitor& monitor) {
    fits->inputs = InputFiles(of ? *of : Stack{});
    fits->target = target_of(lobes, fits->given.get(), of, options, monitor);
    const ParametricStack varied = parametric_stack(stack, vary, fits->target.plan.channels);
    fits->nearest = nearest_stack(fits->target, varied, request,
                                  norm == "log" ? FitNorm::logarithmic : FitNorm::relative,
                                  sides == "reflect" ? FitSides::reflect : FitSides::all, monitor);
    if (!lobes && !monitor.is_stopped())
      if (const auto others = held_out_directions(fits->target.request.directions); !others.empty())
        judge_stack_held_out(fits->nearest,
                             target_of(lobes, fits->given.get(), of, options, monitor, others),
                             varied, request, monitor);
    fits->inputs.check();
  });
  return py::make_tuple(std::move(fits), end.warnings);
}

// The models as they came out, or the fitted stack, judged by the target.
std::unique_ptr<PythonReport> report_of(const PythonFits& fits) {
  auto report = std::make_unique<PythonReport>();
  do_whole_work([&](const RunMonitor&) {
    report->request = fits.target.request;
    report->infos = fits.families;
    report->inputs = fits.inputs;
    const ModelFit& best = fits.nearest.fits.front();
    if (!best.runs.empty()) {
      auto info = std::make_shared<ModelInfo>();
      report->models.push_back(fitted_stack_model(best, *info));
      report->infos.push_back(std::move(info));
      report->comparison = compare_with_stack(fits.target, best, report->models.front());
      return;
    }
    report->models = bound_models(fits.nearest);
    report->comparison = compare_with(fits.target, report->models);
  });
  return report;
}

}  // namespace

void bind_fit(py::module_& m) {
  py::class_<PythonFits>(m, "Fits")
      .def_property_readonly("answer", [](const PythonFits& f) { return f.answer().dump(); })
      .def_property_readonly("summary",
                             [](const PythonFits& f) { return fit_summary(f.target, f.nearest); })
      .def_property_readonly("interrupted",
                             [](const PythonFits& f) { return f.nearest.interrupted; })
      .def("report", &report_of);
  m.def("fit", &fit);
  m.def("fit_stack", &fit_stack);
}

}  // namespace lamella
