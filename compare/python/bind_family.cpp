#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <array>
#include <tuple>

#include "compare/python/bindings.h"
#include "compare/python/python_family.h"
#include "compare/python/python_function.h"

namespace lamella {

namespace py = pybind11;

namespace {

// Name, lowest, highest, whether it is a colour.
using Range = std::tuple<std::string, double, double, bool>;

std::unique_ptr<PythonFamily> make_family(const std::string& name, const py::object& function,
                                          const std::vector<Range>& ranges, bool transmits) {
  auto info = std::make_shared<ModelInfo>(function_info(name, transmits));
  for (const auto& [key, low, high, is_color] : ranges)
    info->parameters.push_back({.name = key,
                                .kind = is_color ? ParameterKind::color : ParameterKind::number,
                                .unit = "1",
                                .doc = "of the function",
                                .default_value = to_text((low + high) / 2),
                                .min = low,
                                .max = high});
  // The function's last owner drops it with the interpreter's lock held, from whichever thread.
  const std::shared_ptr<py::object> held(new py::object(function), [](py::object* owned) {
    const py::gil_scoped_acquire acquire;
    delete owned;
  });
  info->make = [name, held, transmits](const Parameters& parameters, const Stack*) {
    const py::gil_scoped_acquire acquire;
    py::dict keywords;
    for (const auto& [key, value] : parameters.all()) {
      if (const auto* number = std::get_if<double>(&value))
        keywords[py::str(key)] = *number;
      else if (const auto* color = std::get_if<Rgb>(&value))
        keywords[py::str(key)] =
            py::array_t<double>(3, std::array{color->r, color->g, color->b}.data());
    }
    const py::object partial = py::module_::import("functools").attr("partial");
    return function_model(name, partial(*held, **keywords), transmits);
  };
  return std::make_unique<PythonFamily>(PythonFamily{std::move(info)});
}

}  // namespace

void bind_family(py::module_& m) {
  py::class_<PythonFamily>(m, "Family").def_property_readonly("name", [](const PythonFamily& f) {
    return f.info->name;
  });
  m.def("make_family", &make_family);
}

}  // namespace lamella
