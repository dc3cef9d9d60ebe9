#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <memory>
#include <vector>

#include "compare/library/library_index.h"
#include "compare/python/arrays.h"
#include "compare/python/bindings.h"
#include "compare/python/python_lobes.h"

namespace lamella {

namespace py = pybind11;

namespace {

// The entries as index.json has them.
std::string index_text(const std::string& folder) { return to_text(read_index(folder)); }

// Lobes, then of the points w_i, w_o, f and the errors of f.
py::tuple read_entry(const std::string& folder, const std::string& name) {
  const LibraryIndex index = read_index(folder);
  std::vector<std::string> names;
  for (const LibraryEntry& entry : index.entries) names.push_back(entry.name);
  check_names({name}, names, "library");
  auto lobes = std::make_unique<PythonLobes>();
  Reference reference;
  {
    const py::gil_scoped_release release;
    reference = read_reference(*index.find(name), folder);
  }
  lobes->set = std::move(reference.set);
  lobes->estimator = reference.lobe_method.name;
  lobes->bounded = reference.lobe_method.is_bounded();
  std::vector<Direction> wi, wo;
  for (const DirectionPair& pair : reference.pairs) {
    wi.push_back(pair.wi);
    wo.push_back(pair.wo);
  }
  const int channels = lobes->set.channels;
  return py::make_tuple(std::move(lobes), array_of(wi), array_of(wo),
                        array_of(reference.f, channels), array_of(reference.f_error, channels));
}

}  // namespace

void bind_library(py::module_& m) {
  m.def("library_index", &index_text);
  m.def("library_entry", &read_entry);
}

}  // namespace lamella
