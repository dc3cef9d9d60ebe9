#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "analytic/catalogue/model_plugin.h"
#include "compare/command/command.h"
#include "compare/judge/model_configurations.h"
#include "compare/python/bindings.h"
#include "compare/python/bound_model.h"
#include "compare/python/keyword_options.h"
#include "compare/python/python_family.h"
#include "compare/python/work.h"
#include "compare/report/report_page.h"
#include "compare/request/errors.h"
#include "compare/request/model_file.h"
#include "compare/request/stack_parameters.h"

namespace lamella {

namespace py = pybind11;

namespace {

// The answer of a battery, its text, its page, and whether it was interrupted.
struct PythonCheck {
  CheckAnswer found;
  std::string request;
  bool interrupted = false;
};

// What is checked: a model with fixed parameters, or one over its parameters.
struct Checked {
  ModelInfo info;
  std::string request;
  std::vector<CheckConfiguration> configurations;
};

Checked checked_text(const std::string& text, const std::optional<Stack>& stack, int most,
                     std::uint64_t seed) {
  const ModelRequest request = parse_model_request(model_text(text));
  check_request(request);
  const ModelInfo& info = *find_or_load_model(request.name);
  if (!info.needs_stack && stack)
    throw UsageError(
        fmt::format("check: found a stack beside {}; allowed: of a model that is "
                    "built from one",
                    info.name));
  return {info, to_request(request), configurations_to_check(info, request, stack, most, seed)};
}

Checked checked_model(const std::shared_ptr<PythonModel>& model) {
  const ModelInfo& info = *model->bound.info;
  const std::string request = model->own_info ? info.name : to_request(model->bound);
  return {info, request, {{request, [model]() {
                             return std::shared_ptr<const Model>(model, model->bound.model.get());
                           }}}};
}

Checked checked_family(const PythonFamily& family, int most, std::uint64_t seed) {
  const std::shared_ptr<const ModelInfo> info = family.info;
  Checked checked{*info, info->name, {}};
  for (const ModelRequest& request : configurations_of(*info, {info->name, {}}, most, seed))
    checked.configurations.push_back(
        {to_request(request), [info, request]() -> std::shared_ptr<const Model> {
           return info->make(read_parameters(info->name, info->parameters, request.values),
                             nullptr);
         }});
  return checked;
}

// Against entries of a library: a text, and a closed form that is built from no stack, claim what
// the catalogue says; others the entries that are named.
std::vector<CheckLine> library_lines(const PythonModel* model, const PythonFamily* family,
                                     const std::string& text, const LibraryUse& use,
                                     const RunMonitor& monitor) {
  if (family) {
    const std::shared_ptr<const ModelInfo> info = family->info;
    const auto make = [&](const ModelRequest& entry, const Stack& stack) {
      const ModelRequest asked = with_stack_parameters({info->name, entry.values}, *info, stack);
      Parameters parameters = read_parameters(info->name, info->parameters, asked.values);
      BoundModel bound;
      bound.info = info.get();
      bound.parameters = parameters;
      bound.model = info->make(parameters, nullptr);
      return bound;
    };
    return check_on_library(info->name, make, use, monitor);
  }
  if (!model) return check_on_library(parse_model_request(model_text(text)), use, monitor);
  if (!model->own_info && !model->bound.info->needs_stack)
    return check_on_library(parse_model_request(to_request(model->bound)), use, monitor);
  const std::string& name = model->bound.info->name;
  const auto make = [&](const ModelRequest& entry, const Stack&) {
    if (!entry.values.empty())
      throw UsageError(fmt::format(
          "--entry: {}: found a key beside {}, whose parameters are fixed; allowed: the name alone",
          entry.name, name));
    return copy_of(*model);
  };
  return check_on_library(name, make, use, monitor);
}

// `model`: a text, a Model or a Family. `reciprocal`: what a function claims, None: as it is known.
py::tuple check(const py::object& model, const std::optional<Stack>& stack,
                const std::optional<bool>& reciprocal, std::optional<int> configurations,
                std::optional<std::uint64_t> samples, const std::string& library,
                const std::vector<std::string>& entries, const py::dict& keywords,
                const py::object& show) {
  const Options options = options_of(keywords);
  CheckOptions effort = options.quick ? kQuickCheck : CheckOptions{};
  if (configurations) effort.configurations = *configurations;
  if (samples) effort.samples = *samples;
  effort.library = library;
  effort.entries = entries;
  const auto use = library_use(options, effort);
  auto found = std::make_unique<PythonCheck>();
  Checked checked;
  const PythonFamily* family = nullptr;
  std::shared_ptr<PythonModel> fixed;
  if (py::isinstance<PythonFamily>(model)) {
    family = py::cast<const PythonFamily*>(model);
    checked = checked_family(*family, effort.configurations, options.seed);
  } else if (py::isinstance<PythonModel>(model)) {
    fixed = py::cast<std::shared_ptr<PythonModel>>(model);
    checked = checked_model(fixed);
  }
  const std::string text =
      checked.configurations.empty() ? py::cast<std::string>(model) : std::string();
  WorkEnd end = do_work(options.threads, show, [&](const RunMonitor& monitor) {
    if (checked.configurations.empty())
      checked = checked_text(text, stack, effort.configurations, options.seed);
    if (reciprocal) checked.info.reciprocal = *reciprocal;
    found->request = checked.request;
    std::vector<CheckLine> on_library;
    if (use) on_library = library_lines(fixed.get(), family, text, *use, monitor);
    found->found = check_answer(checked.info, checked.request, checked.configurations, options,
                                effort, monitor, on_library);
    found->interrupted = monitor.is_stopped();
  });
  return py::make_tuple(std::move(found), end.warnings);
}

}  // namespace

void bind_check(py::module_& m) {
  py::class_<PythonCheck>(m, "Check")
      .def_property_readonly("answer",
                             [](const PythonCheck& c) { return c.found.answer.json.dump(); })
      .def_property_readonly("text", [](const PythonCheck& c) { return c.found.text; })
      .def_property_readonly("page",
                             [](const PythonCheck& c) {
                               return report_page(c.request + ": check", c.found.answer.json,
                                                  nullptr);
                             })
      .def_readonly("interrupted", &PythonCheck::interrupted);
  m.def("check", &check);
}

}  // namespace lamella
