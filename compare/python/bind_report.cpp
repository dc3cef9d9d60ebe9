#include <pybind11/stl.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "compare/drawing/picture_format.h"
#include "compare/exchange/measured_comparison.h"
#include "compare/files/folder_lock.h"
#include "compare/files/output_folder.h"
#include "compare/fit/fitted_models.h"
#include "compare/judge/stack_comparison.h"
#include "compare/python/bindings.h"
#include "compare/python/bound_model.h"
#include "compare/python/keyword_options.h"
#include "compare/python/python_lobes.h"
#include "compare/python/python_report.h"
#include "compare/python/work.h"
#include "compare/report/comparison_report.h"
#include "compare/report/json_report.h"
#include "compare/report/report_page.h"
#include "compare/request/model_file.h"

namespace lamella {

namespace py = pybind11;

namespace {

// Models that were made already, or texts as --model has them; none: all that apply.
std::vector<BoundModel> models_of(PythonReport& report, const std::vector<py::object>& asked,
                                  const std::vector<std::string>& texts, const Stack& stack) {
  std::vector<BoundModel> models;
  if (asked.empty()) return fitted_models_for({}, stack);
  for (std::size_t k = 0; k < asked.size(); ++k) {
    if (texts[k].empty()) {
      models.push_back(copy_of(*report.given[k]));
      continue;
    }
    for (BoundModel& bound : fitted_models_for({parse_model_request(texts[k])}, stack))
      models.push_back(std::move(bound));
  }
  return models;
}

// The report and the warnings.
py::tuple compare_models(const Stack& stack, const std::vector<py::object>& asked,
                         const py::dict& keywords, const py::object& show) {
  const Options options = options_of(keywords);
  auto report = std::make_unique<PythonReport>();
  report->request = truth_request(options, stack);
  std::vector<std::string> texts;
  for (const py::object& model : asked) {
    const bool text = py::isinstance<py::str>(model);
    texts.push_back(text ? model_text(py::cast<std::string>(model)) : "");
    report->given.push_back(text ? nullptr : py::cast<std::shared_ptr<PythonModel>>(model));
  }
  WorkEnd end = do_work(options.threads, show, [&](const RunMonitor& monitor) {
    GroundTruth truth(report->request, Estimator::analog, monitor);
    report->models = models_of(*report, asked, texts, stack);
    report->inputs = InputFiles(stack, objects_of(report->models));
    report->comparison = compare_stack(truth, report->models);
    report->inputs.check();
  });
  return py::make_tuple(std::move(report), end.warnings);
}

// The same where the truth is a measured material; texts are closed forms by themselves.
py::tuple compare_with_measured(const std::shared_ptr<PythonModel>& measured,
                                const std::vector<py::object>& asked, const py::dict& keywords,
                                const py::object& show) {
  const Options options = options_of(keywords);
  auto report = std::make_unique<PythonReport>();
  TruthRequest& request = report->request;
  request.stack.name = measured->bound.info->name;
  request.directions = incident_directions(options, Stack{});
  request.cells = parse_grid(options.grid);
  request.isa = isa_of(options);
  for (const py::object& model : asked) {
    if (py::isinstance<py::str>(model)) {
      report->models.push_back(
          bind_model(parse_model_request(model_text(py::cast<std::string>(model))), nullptr));
      continue;
    }
    report->given.push_back(py::cast<std::shared_ptr<PythonModel>>(model));
    report->models.push_back(copy_of(*report->given.back()));
  }
  WorkEnd end = do_work(options.threads, show, [&](const RunMonitor& monitor) {
    report->inputs = InputFiles(Stack{}, objects_of(report->models));
    report->comparison = compare_with_model(
        {*measured->bound.model, *measured->bound.info, "a closed form or a measured material"},
        request, report->models, monitor);
  });
  return py::make_tuple(std::move(report), end.warnings);
}

}  // namespace

void save_report(const PythonReport& report, const std::string& folder,
                 const std::vector<std::string>& pictures) {
  const std::vector<PictureFormat> formats = picture_formats(pictures);
  make_output_folder(folder);
  const FolderLock lock(folder);
  (void)write_comparison_files(folder, report.request, report.comparison, formats, report.inputs);
  const nlohmann::ordered_json answer = report.answer();
  write_json(answer, folder + "/report.json");
  write_file(folder + "/summary.txt", comparison_summary(report.request, report.comparison));
  write_report_page(folder + "/report.html", report.title(), answer,
                    comparison_details(report.comparison));
}

namespace {

std::unique_ptr<PythonLobes> truth_lobes(const PythonReport& report) {
  return simulated_lobes(report.request, report.comparison.runs, report.comparison.choice,
                         report.inputs, report.comparison.interrupted);
}

}  // namespace

nlohmann::ordered_json PythonReport::answer() const {
  nlohmann::ordered_json json = comparison_json(request, comparison);
  add_files(json, inputs);
  return json;
}

void bind_report(py::module_& m) {
  py::class_<PythonReport>(m, "Report")
      .def_property_readonly("answer", [](const PythonReport& r) { return r.answer().dump(); })
      .def_property_readonly(
          "summary",
          [](const PythonReport& r) { return comparison_summary(r.request, r.comparison); })
      .def_property_readonly("page",
                             [](const PythonReport& r) {
                               return report_page(r.title(), r.answer(),
                                                  comparison_details(r.comparison));
                             })
      .def_property_readonly("names",
                             [](const PythonReport& r) {
                               std::vector<std::string> names;
                               for (const JudgedModel& j : r.comparison.models)
                                 names.push_back(j.name);
                               return names;
                             })
      .def_property_readonly(
          "worst_relative_rmse",
          [](const PythonReport& r) { return worst_relative_rmse(r.comparison); })
      .def_property_readonly("interrupted",
                             [](const PythonReport& r) { return r.comparison.interrupted; })
      .def("truth", &truth_lobes)
      .def("save", &save_report, py::call_guard<py::gil_scoped_release>());
  m.def("compare", &compare_models);
  m.def("compare_measured", &compare_with_measured);
}

}  // namespace lamella
