#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <memory>

#include "compare/python/arrays.h"
#include "compare/python/bindings.h"
#include "compare/python/keyword_options.h"
#include "compare/python/work.h"
#include "compare/samples/sample_file.h"

namespace lamella {

namespace py = pybind11;

namespace {

// Walks one by one, and what they are of.
struct PythonSamples {
  std::unique_ptr<SampleRequest> request;
  InputFiles inputs;
  WalkSamples rows;
  std::vector<SampleTotals> totals;
  bool interrupted = false;

  [[nodiscard]] bool has_directions() const { return request->law == IncidentLaw::fixed; }
};

void append(WalkSamples& to, const WalkSamples& from) {
  const auto add = [](auto& column, const auto& more) {
    column.insert(column.end(), more.begin(), more.end());
  };
  to.walks += from.walks;
  add(to.wi, from.wi);
  add(to.wo, from.wo);
  add(to.weight, from.weight);
  add(to.order, from.order);
  add(to.side, from.side);
}

// A column as an array that looks at it, read only; `width` 0: one number a row.
template <class T>
py::array column(const SampleColumn<T>& numbers, py::ssize_t width, const py::object& self) {
  const auto count = static_cast<py::ssize_t>(numbers.size());
  std::vector<py::ssize_t> shape{count};
  if (width > 0) shape = {count / width, width};
  py::array array(py::dtype::of<T>(), shape, numbers.data(), self);
  array.attr("flags").attr("writeable") = false;
  return array;
}

const PythonSamples& of(const py::object& self) { return py::cast<const PythonSamples&>(self); }

py::array_t<std::uint64_t> per_direction(const PythonSamples& s,
                                         std::uint64_t SampleTotals::*member) {
  std::vector<std::uint64_t> numbers;
  for (const SampleTotals& one : s.totals)
    if (s.has_directions()) numbers.push_back(one.*member);
  return py::array_t<std::uint64_t>(static_cast<py::ssize_t>(numbers.size()), numbers.data());
}

py::array_t<double> directions(const PythonSamples& s) {
  std::vector<Direction> list;
  for (const SampleTotals& one : s.totals)
    if (s.has_directions()) list.push_back(one.incident);
  return array_of(list);
}

std::uint64_t save(const PythonSamples& s, const std::string& path) {
  const py::gil_scoped_release release;
  SampleFile file(path, s.rows.channels);
  file.add(s.rows);
  return file.finish(*s.request, s.totals, s.inputs);
}

// Samples and the warnings.
py::tuple samples(const Stack& stack, const py::dict& keywords, const py::object& show) {
  const Options options = options_of(keywords);
  const TruthRequest truth = truth_request(options, stack);
  const IncidentLaw law = incident_law_of(options);
  auto found = std::make_unique<PythonSamples>();
  WorkEnd end = do_work(options.threads, show, [&](const RunMonitor& monitor) {
    found->inputs = InputFiles(stack);
    found->request = std::make_unique<SampleRequest>(truth, law);
    found->rows.channels = found->request->plan.channels;
    found->totals = stream_samples(*found->request, monitor, [&](const SampleChunk& chunk) {
      append(found->rows, chunk.samples);
    });
    found->inputs.check();
  });
  found->interrupted = end.interrupted;
  return py::make_tuple(std::move(found), end.warnings);
}

}  // namespace

void bind_samples(py::module_& m) {
  py::class_<PythonSamples>(m, "Samples")
      .def_property_readonly("w_i",
                             [](py::object self) { return column(of(self).rows.wi, 3, self); })
      .def_property_readonly("w_o",
                             [](py::object self) { return column(of(self).rows.wo, 3, self); })
      .def_property_readonly("weight",
                             [](py::object self) {
                               const WalkSamples& rows = of(self).rows;
                               return column(rows.weight, rows.channels, self);
                             })
      .def_property_readonly("order",
                             [](py::object self) { return column(of(self).rows.order, 0, self); })
      .def_property_readonly("side",
                             [](py::object self) { return column(of(self).rows.side, 0, self); })
      .def_property_readonly("walks", [](const PythonSamples& s) { return s.rows.walks; })
      .def_property_readonly("directions", &directions)
      .def_property_readonly(
          "direction_walks",
          [](const PythonSamples& s) { return per_direction(s, &SampleTotals::walks); })
      .def_property_readonly(
          "direction_rows",
          [](const PythonSamples& s) { return per_direction(s, &SampleTotals::rows); })
      .def_property_readonly(
          "about",
          [](const PythonSamples& s) { return samples_about(*s.request, s.inputs, "").dump(); })
      .def_readonly("interrupted", &PythonSamples::interrupted)
      .def("save", &save);
  m.def("samples", &samples);
}

}  // namespace lamella
