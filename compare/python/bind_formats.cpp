#include <pybind11/stl.h>

#include <memory>

#include "compare/exchange/exported.h"
#include "compare/exchange/projected_lobes.h"
#include "compare/files/output_folder.h"
#include "compare/python/bindings.h"
#include "compare/python/bound_model.h"
#include "compare/python/keyword_options.h"
#include "compare/python/python_lobes.h"
#include "compare/python/work.h"
#include "compare/request/errors.h"

namespace lamella {

namespace py = pybind11;

namespace {

// Bytes written, the format's error, and what is left out.
py::tuple save_brdf(const PythonModel& model, const std::string& path, const std::string& format,
                    const std::string& size) {
  const auto known = parse_brdf_format(format);
  if (!known) throw UsageError("--to: found \"" + format + "\"; allowed: mitsuba, pbrt, merl");
  const TensorSize nodes = tensor_size(size);
  check_output_file(path);
  std::size_t bytes = 0;
  double error = 0;
  std::vector<std::string> left_out;
  do_whole_work([&](const RunMonitor&) {
    const ExportedBrdf source = exported_model(model.bound);
    const std::string written = brdf_bytes(source, *known, nodes);
    error = format_error(source, *read_brdf(written, path));
    left_out = source.left_out;
    bytes = written.size();
    write_file(path, written);
  });
  return py::make_tuple(bytes, error, left_out);
}

std::unique_ptr<PythonLobes> lobes_of_model(const PythonModel& model, const py::dict& keywords) {
  const Options options = options_of(keywords);
  auto lobes = std::make_unique<PythonLobes>();
  do_whole_work([&](const RunMonitor&) {
    lobes->set = projected_lobes(*model.bound.model, *model.bound.info,
                                 incident_directions(options, Stack{}), parse_grid(options.grid),
                                 model.channels);
    lobes->set.attributes["lamella.source"] =
        model.own_info ? model.own_info->name : to_request(model.bound);
  });
  lobes->estimator = "projection of " + model.bound.info->name;
  return lobes;
}

}  // namespace

void bind_formats(py::module_& m) {
  m.def("save_brdf", &save_brdf);
  m.def("lobes_of_model", &lobes_of_model);
}

}  // namespace lamella
