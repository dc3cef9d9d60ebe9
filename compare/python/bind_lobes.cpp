#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <nlohmann/json.hpp>

#include "compare/exchange/lobe_archive.h"
#include "compare/files/exr_file.h"
#include "compare/files/output_folder.h"
#include "compare/python/arrays.h"
#include "compare/python/bindings.h"
#include "compare/python/python_lobes.h"
#include "compare/report/json_report.h"
#include "compare/report/lobe_files.h"
#include "compare/request/errors.h"
#include "phase/math/degrees.h"

namespace lamella {

namespace py = pybind11;

namespace {

py::ssize_t size(std::size_t n) { return static_cast<py::ssize_t>(n); }

std::string keys_text(const LobeSet& set) {
  std::string text;
  for (const LobeBlock& b : set.lobes)
    text += fmt::format("{}(\"{}\", \"{}\")", text.empty() ? "" : ", ", b.side, b.name);
  return text;
}

// A block of lobes as [direction, mu, phi, channel]; in memory [direction, channel, mu, phi].
py::array lobe_view(py::object self, const std::string& side, const std::string& name, bool error) {
  const LobeSet& set = py::cast<const PythonLobes&>(self).set;
  const LobeBlock* block = set.lobe(side, name);
  if (!block)
    throw py::key_error(
        fmt::format("(\"{}\", \"{}\"): not there; allowed: {}", side, name, keys_text(set)));
  const py::ssize_t mu = set.grid.rows(), phi = set.grid.columns(), channels = set.channels;
  const std::vector<double>& numbers = error ? block->standard_error : block->value;
  if (numbers.empty())
    throw py::key_error(
        fmt::format("(\"{}\", \"{}\"): its standard error is not known", side, name));
  return view_of(numbers, {size(set.directions.size()), mu, phi, channels},
                 {channels * mu * phi, phi, 1, mu * phi}, self);
}

// Energies as a list of (side, name, value, standard error), arrays [direction, channel].
py::list energies(py::object self) {
  const LobeSet& set = py::cast<const PythonLobes&>(self).set;
  const py::ssize_t directions = size(set.directions.size()), channels = set.channels;
  py::list list;
  for (const LobeBlock& b : set.energies) {
    const auto view = [&](const std::vector<double>& numbers) -> py::object {
      if (numbers.empty()) return py::none();
      return view_of(numbers, {directions, channels}, {channels, 1}, self);
    };
    list.append(py::make_tuple(b.side, b.name, view(b.value), view(b.standard_error)));
  }
  return list;
}

py::array_t<double> degrees(const PythonLobes& lobes, double (*of)(Direction)) {
  py::array_t<double> array(size(lobes.set.directions.size()));
  auto numbers = array.mutable_unchecked<1>();
  for (std::size_t k = 0; k < lobes.set.directions.size(); ++k)
    numbers(size(k)) = of(lobes.set.directions[k]);
  return array;
}

py::array_t<double> edges(const PythonLobes& lobes, bool mu) {
  const CellGrid& grid = lobes.set.grid;
  const int count = mu ? grid.rows() : grid.columns();
  py::array_t<double> array(count + 1);
  auto numbers = array.mutable_unchecked<1>();
  for (int k = 0; k <= count; ++k) numbers(k) = mu ? grid.edge_mu(k) : grid.edge_phi(k);
  return array;
}

// The set with the header that a file in `folder` has.
void save_exr(PythonLobes& lobes, const std::string& path) {
  const auto folder = std::filesystem::path(path).parent_path();
  if (lobes.request)
    lobes.set.attributes = file_attributes(named_for_image(*lobes.request, folder), lobes.runs);
  ExrImage image = lobe_image(lobes.set);
  record_files(image, lobes.inputs, folder);
  write_exr(path, image);
}

// A NumPy archive or CSV, with the header that an EXR file has.
void save_archive(PythonLobes& lobes, const std::string& path) {
  const auto folder = std::filesystem::path(path).parent_path();
  if (lobes.request)
    lobes.set.attributes = file_attributes(named_for_image(*lobes.request, folder), lobes.runs);
  write_file(path, path.ends_with(".csv") ? lobe_csv(lobes.set) : lobe_npz(lobes.set));
}

std::unique_ptr<PythonLobes> read(const std::string& path, const std::string& part) {
  auto lobes = std::make_unique<PythonLobes>();
  lobes->set = read_lobes(path, part);
  const auto at = lobes->set.attributes.find("lamella.estimator");
  if (at != lobes->set.attributes.end()) lobes->estimator = at->second + " estimator";
  return lobes;
}

std::map<std::string, std::string> attributes(const PythonLobes& lobes) {
  return lobes.request ? file_attributes(named_for_image(*lobes.request, ""), lobes.runs)
                       : lobes.set.attributes;
}

}  // namespace

std::unique_ptr<PythonLobes> simulated_lobes(TruthRequest request, std::vector<RunResult> runs,
                                             const EstimatorChoice& choice, InputFiles inputs,
                                             bool interrupted) {
  nlohmann::ordered_json answer = json_header("simulate", request), list;
  std::uint64_t collisions = 0;
  for (const RunResult& run : runs) {
    collisions += run.collisions;
    list.push_back(to_json(run));
  }
  add_choice(answer, choice, request);
  answer["walks"] = runs.front().walks;
  answer["collisions"] = collisions;
  answer["interrupted"] = interrupted;
  answer["runs"] = std::move(list);
  add_files(answer, inputs);
  auto lobes = std::make_unique<PythonLobes>();
  lobes->set = take_lobes(runs);
  lobes->answer = answer.dump();
  lobes->estimator = estimator_text(choice, request);
  lobes->request = std::move(request);
  lobes->runs = std::move(runs);
  lobes->inputs = std::move(inputs);
  lobes->interrupted = interrupted;
  return lobes;
}

void bind_lobes(py::module_& m) {
  py::class_<PythonLobes>(m, "Lobes")
      .def_property_readonly("keys",
                             [](const PythonLobes& lobes) {
                               py::list keys;
                               for (const LobeBlock& b : lobes.set.lobes)
                                 keys.append(py::make_tuple(b.side, b.name));
                               return keys;
                             })
      .def("values", [](py::object self, const std::string& side,
                        const std::string& name) { return lobe_view(self, side, name, false); })
      .def("errors", [](py::object self, const std::string& side,
                        const std::string& name) { return lobe_view(self, side, name, true); })
      .def("energies", &energies)
      .def_property_readonly("theta",
                             [](const PythonLobes& l) { return degrees(l, &theta_degrees); })
      .def_property_readonly("phi", [](const PythonLobes& l) { return degrees(l, &phi_degrees); })
      .def_property_readonly("directions",
                             [](const PythonLobes& l) { return array_of(l.set.directions); })
      .def_property_readonly("mu_edges", [](const PythonLobes& l) { return edges(l, true); })
      .def_property_readonly("phi_edges", [](const PythonLobes& l) { return edges(l, false); })
      .def_property_readonly("folded", [](const PythonLobes& l) { return l.set.grid.folded; })
      .def_property_readonly("channels", [](const PythonLobes& l) { return l.set.channels; })
      .def_property_readonly("attributes", &attributes)
      .def_property_readonly("is_bounded",
                             [](const PythonLobes& l) {
                               return l.runs.empty() ? l.bounded : l.runs.front().is_bounded();
                             })
      .def_readonly("answer", &PythonLobes::answer)
      .def_readonly("estimator", &PythonLobes::estimator)
      .def_readonly("interrupted", &PythonLobes::interrupted)
      .def("save_exr", &save_exr)
      .def("save_archive", &save_archive);
  m.def("read_lobes", &read);
}

}  // namespace lamella
