#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include "analytic/catalogue/model_plugin.h"
#include "analytic/model/grazing_pair.h"
#include "analytic/model/stochastic_model.h"
#include "compare/exchange/exported.h"
#include "compare/exchange/tensor_container.h"
#include "compare/fit/fitted_models.h"
#include "compare/options/options.h"
#include "compare/python/arrays.h"
#include "compare/python/bindings.h"
#include "compare/python/bound_model.h"
#include "compare/python/python_function.h"
#include "compare/python/work.h"
#include "compare/request/errors.h"
#include "compare/request/model_file.h"
#include "compare/request/stack_parameters.h"

namespace lamella {

namespace py = pybind11;

namespace {

// Below it a thread of its own costs more than it saves.
constexpr std::size_t kFewPairs = 2048;

bool has_three_values(const KeyValues& values) {
  return std::any_of(values.begin(), values.end(), [](const auto& v) {
    return v.first != "axis" && std::count(v.second.begin(), v.second.end(), ',') == 2;
  });
}

// "NAME", "NAME,key=value,..." or "@FILE", with further keys.
std::shared_ptr<PythonModel> make_model(const std::string& text, const KeyValues& further,
                                        const std::optional<Stack>& stack) {
  ModelRequest request = parse_model_request(model_text(text));
  for (const auto& value : further) request.values.push_back(value);
  auto model = std::make_shared<PythonModel>();
  model->stack = stack;
  do_whole_work([&](const RunMonitor&) {
    const ModelInfo* info = find_or_load_model(request.name);
    // A model that is built from a stack is `eval`'s; others take parameters from it.
    if (stack && info && !info->needs_stack)
      model->bound = model_for(request, *stack);
    else
      model->bound = bind_model(stack ? with_fitted_lobes(request, *stack) : request,
                                stack ? &*stack : nullptr);
  });
  const bool colored = has_three_values(request.values) || model->bound.parameters.has_color() ||
                       !model->bound.object.empty() || (stack && !stack->is_grey());
  model->channels = colored ? 3 : 1;
  return model;
}

std::shared_ptr<PythonModel> make_function(const std::string& name, const py::object& function,
                                           bool transmits) {
  auto model = std::make_shared<PythonModel>();
  model->own_info = std::make_shared<const ModelInfo>(function_info(name, transmits));
  model->function = function;
  model->bound = copy_of(*model);
  model->channels = channels_of_function(name, function);
  return model;
}

int lobe_of(const PythonModel& model, const std::string& name) {
  if (name.empty()) return -1;
  std::vector<std::string> names;
  for (const LobeInfo& lobe : model.bound.info->lobes) names.push_back(lobe.name);
  const auto it = std::find(names.begin(), names.end(), name);
  if (it != names.end()) return static_cast<int>(it - names.begin());
  const std::string hint = suggestion(name, names);
  throw UsageError(fmt::format("{}: part \"{}\": unknown{}; allowed: {}", model.bound.info->name,
                               name, hint.empty() ? "" : ", " + hint, listed(names)));
}

Rgb value_of(const PythonModel& model, int lobe, Direction given_i, Direction given_o) {
  const auto f = [&](Direction wi, Direction wo) {
    return lobe < 0 ? model.bound.model->eval(wi, wo) : model.bound.model->eval_lobe(lobe, wi, wo);
  };
  const Direction wi = with_grazing_limit(given_i), wo = with_grazing_limit(given_o);
  if (!grazes_twice(given_i, given_o)) return f(wi, wo);
  if (const auto limit = limit_where_both_graze(f, wi, wo)) return *limit;
  throw std::invalid_argument(
      fmt::format("{}: both cosines are 0, where there is no limit; allowed: at most one",
                  model.bound.info->name));
}

py::array_t<double> eval(const PythonModel& model, const Doubles1& wi, const Doubles1& wo,
                         const std::string& lobe_name, const std::string& isa_name) {
  const std::vector<Direction> in = directions_of(wi, "wi"), out = directions_of(wo, "wo");
  const int lobe = lobe_of(model, lobe_name);
  const Isa isa = parse_isa(isa_name);
  std::vector<Rgb> values(in.size());
  if (model.is_function() || (lobe < 0 && isa != Isa::scalar)) {
    std::vector<DirectionPair> pairs;
    for (std::size_t k = 0; k < in.size(); ++k)
      pairs.push_back({with_grazing_limit(in[k]), with_grazing_limit(out[k])});
    if (model.is_function()) {
      model.bound.model->eval(pairs, values, Isa::scalar);
    } else {
      const py::gil_scoped_release release;
      model.bound.model->eval(pairs, values, isa);
    }
    return array_of(values, model.channels);
  }
  // Pair by pair as the command line does, so that both give the same bits.
  if (in.size() < kFewPairs) {
    const py::gil_scoped_release release;
    for (std::size_t k = 0; k < in.size(); ++k) values[k] = value_of(model, lobe, in[k], out[k]);
  } else {
    do_whole_work([&](const RunMonitor& monitor) {
      tbb::parallel_for(std::size_t{0}, in.size(), [&](std::size_t k) {
        if (!monitor.is_stopped()) values[k] = value_of(model, lobe, in[k], out[k]);
      });
    });
  }
  return array_of(values, model.channels);
}

py::array_t<double> pdf(const PythonModel& model, const Doubles1& wi, const Doubles1& wo) {
  const std::vector<Direction> in = directions_of(wi, "wi"), out = directions_of(wo, "wo");
  py::array_t<double> densities(static_cast<py::ssize_t>(in.size()));
  double* const to = densities.mutable_data();
  const py::gil_scoped_release release;
  for (std::size_t k = 0; k < in.size(); ++k)
    to[k] = model.bound.model->pdf(with_grazing_limit(in[k]), with_grazing_limit(out[k]));
  return densities;
}

py::array_t<double> sample(const PythonModel& model, const Doubles1& wo, const Doubles1& u) {
  const std::vector<Direction> out = directions_of(wo, "wo");
  const auto uniforms = u.unchecked<2>();
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::vector<Direction> drawn(out.size(), {kNone, kNone, kNone});
  for (std::size_t k = 0; k < out.size(); ++k) {
    const auto row = static_cast<py::ssize_t>(k);
    for (int n = 0; n < 3; ++n)
      if (!(uniforms(row, n) > 0 && uniforms(row, n) < 1))
        throw std::invalid_argument(
            fmt::format("u: found {} in row {}; allowed: numbers in (0, 1)", uniforms(row, n), k));
    if (const auto w = model.bound.model->sample(with_grazing_limit(out[k]), uniforms(row, 0),
                                                 uniforms(row, 1), uniforms(row, 2)))
      drawn[k] = *w;
  }
  return array_of(drawn);
}

// Albedos and their errors.
py::tuple albedo(const PythonModel& model, const Doubles1& wi) {
  const std::vector<Direction> in = directions_of(wi, "wi");
  std::vector<Rgb> values(in.size()), errors(in.size());
  do_whole_work([&](const RunMonitor& monitor) {
    const auto find = [&](std::size_t k) {
      if (monitor.is_stopped()) return;
      const AlbedoEstimate found = model.bound.model->albedo_with_error(with_grazing_limit(in[k]));
      values[k] = found.value;
      errors[k] = found.error;
    };
    if (model.is_function())
      for (std::size_t k = 0; k < in.size(); ++k) find(k);
    else
      tbb::parallel_for(std::size_t{0}, in.size(), find);
  });
  return py::make_tuple(array_of(values, model.channels), array_of(errors, model.channels));
}

py::dict parameters_dict(const PythonModel& model) {
  py::dict dict;
  for (const auto& [key, value] : model.bound.parameters.all()) {
    py::object python;
    if (const auto* number = std::get_if<double>(&value))
      python = py::float_(*number);
    else if (const auto* color = std::get_if<Rgb>(&value))
      python = color->is_grey() ? py::object(py::float_(color->r))
                                : py::object(py::make_tuple(color->r, color->g, color->b));
    else if (const auto* list = std::get_if<std::vector<double>>(&value))
      python = py::tuple(py::cast(*list));
    else
      python = py::str(std::get<std::string>(value));
    dict[py::str(key)] = python;
  }
  return dict;
}

// A measured material that several comparisons share.
class SharedModel : public Model {
 public:
  explicit SharedModel(std::shared_ptr<const Model> model) : Model(1), model_(std::move(model)) {}
  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    return model_->eval_lobe(lobe, wi, wo);
  }

 private:
  std::shared_ptr<const Model> model_;
};

std::shared_ptr<PythonModel> read_measured(const std::string& path) {
  auto model = std::make_shared<PythonModel>();
  model->own_info =
      std::make_shared<const ModelInfo>(measured_info(std::filesystem::path(path).stem().string()));
  model->measured = read_brdf(read_format_file(path), path);
  model->bound = copy_of(*model);
  model->channels = 3;
  return model;
}

}  // namespace

BoundModel copy_of(const PythonModel& model) {
  if (model.is_function()) {
    const py::gil_scoped_acquire acquire;
    BoundModel bound;
    bound.info = model.own_info.get();
    bound.model = function_model(model.own_info->name, model.function, model.own_info->transmits);
    return bound;
  }
  if (model.measured) {
    BoundModel bound;
    bound.info = model.own_info.get();
    bound.model = std::make_unique<SharedModel>(model.measured);
    return bound;
  }
  const Stack* stack = model.stack ? &*model.stack : nullptr;
  BoundModel bound = bind_model(parse_model_request(to_request(model.bound)), stack);
  bound.sources = model.bound.sources;
  return bound;
}

void bind_model(py::module_& m) {
  py::class_<PythonModel, std::shared_ptr<PythonModel>>(m, "Model")
      .def_property_readonly("name", [](const PythonModel& p) { return p.bound.info->name; })
      .def_property_readonly("doc", [](const PythonModel& p) { return p.bound.info->doc; })
      .def_property_readonly("source", [](const PythonModel& p) { return p.bound.info->source; })
      .def_property_readonly("transmits",
                             [](const PythonModel& p) { return p.bound.info->transmits; })
      .def_property_readonly("is_built_in", [](const PythonModel& p) { return !p.own_info; })
      .def_property_readonly("lobe_names",
                             [](const PythonModel& p) {
                               py::list names;
                               for (const LobeInfo& lobe : p.bound.info->lobes)
                                 names.append(lobe.name);
                               return py::tuple(names);
                             })
      .def_readonly("channels", &PythonModel::channels)
      .def_property_readonly("request",
                             [](const PythonModel& p) {
                               return p.own_info ? p.bound.info->name : to_request(p.bound);
                             })
      .def_property_readonly("parameters", &parameters_dict)
      .def_property_readonly("sources", [](const PythonModel& p) { return p.bound.sources; })
      .def("eval", &eval)
      .def("pdf", &pdf)
      .def("sample", &sample)
      .def("albedo", &albedo);
  m.def("make_model", &make_model);
  m.def("make_function", &make_function);
  m.def("read_measured", &read_measured);
}

}  // namespace lamella
