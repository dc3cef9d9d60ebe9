#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "analytic/model/model.h"
#include "compare/python/arrays.h"
#include "compare/python/bindings.h"
#include "phase/medium/media.h"
#include "phase/stack/builtin_stacks.h"

namespace lamella {

namespace py = pybind11;

namespace {

py::list parameters_list(const std::vector<ParameterInfo>& infos) {
  py::list list;
  for (const ParameterInfo& p : infos)
    list.append(py::dict(py::arg("name") = p.name, py::arg("doc") = p.doc, py::arg("unit") = p.unit,
                         py::arg("default") = p.default_value,
                         py::arg("allowed") = allowed_values(p)));
  return list;
}

py::list models_list() {
  py::list list;
  for (const ModelInfo& m : models()) {
    py::list lobes;
    for (const LobeInfo& lobe : m.lobes) lobes.append(lobe.name);
    list.append(py::dict(py::arg("name") = m.name, py::arg("doc") = m.doc,
                         py::arg("source") = m.source, py::arg("lobes") = lobes,
                         py::arg("needs_stack") = m.needs_stack,
                         py::arg("parameters") = parameters_list(m.parameters)));
  }
  return list;
}

py::list media_list() {
  py::list list;
  for (const MediumInfo& m : media())
    list.append(py::dict(py::arg("name") = m.name, py::arg("doc") = m.doc,
                         py::arg("source") = m.source,
                         py::arg("parameters") = parameters_list(m.parameters)));
  return list;
}

py::list stacks_list() {
  py::list list;
  for (const BuiltinStack& s : builtin_stacks())
    list.append(py::dict(py::arg("name") = s.name, py::arg("doc") = s.doc,
                         py::arg("source") = s.source, py::arg("toml") = s.toml));
  return list;
}

py::array_t<double> directions_from_degrees(const Doubles1& theta, const Doubles1& phi) {
  const auto t = theta.unchecked<1>(), p = phi.unchecked<1>();
  std::vector<Direction> directions;
  for (py::ssize_t k = 0; k < t.shape(0); ++k)
    directions.push_back(direction_from_degrees(t(k), p(k)));
  return array_of(directions);
}

}  // namespace

void bind_lists(py::module_& m) {
  m.def("models", &models_list);
  m.def("media", &media_list);
  m.def("stacks", &stacks_list);
  m.def("directions_from_degrees", &directions_from_degrees);
}

}  // namespace lamella
