#include <fmt/format.h>
#include <pybind11/stl.h>

#include "compare/files/output_folder.h"
#include "compare/maps/surface_stack.h"
#include "compare/python/bindings.h"
#include "compare/report/json_report.h"
#include "compare/request/substrate_model.h"
#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"
#include "phase/stack/stack_paths.h"

namespace lamella {

namespace py = pybind11;

namespace {

Stack builtin_stack(const std::string& name) {
  std::vector<std::string> names;
  for (const BuiltinStack& stack : builtin_stacks()) names.push_back(stack.name);
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    const std::string hint = suggestion(name, names);
    throw StackFileError(fmt::format("built-in stack \"{}\": unknown{}; allowed: {}", name,
                                     hint.empty() ? "" : ", " + hint, listed(names)));
  }
  return with_surface_model(load_stack(name));
}

// A file, whatever built-in stack has its name; with maps the stack of a place.
Stack read_stack(const std::string& path, const std::optional<std::pair<double, double>>& at) {
  const std::string file = path.find('/') == std::string::npos && path != "-" ? "./" + path : path;
  if (!at) return with_surface_model(load_stack(file));
  const SurfaceStack surface(load_mapped_stack(file));
  const auto [u, v] = *at;
  if (!surface.has_maps() || !(u >= 0 && u <= 1 && v >= 0 && v <= 1))
    throw StackFileError(
        fmt::format("at: found ({}, {}) for {}, {}; allowed: u and v from 0 to 1 of a stack with "
                    "pictures among its values",
                    to_text(u), to_text(v), surface.name(),
                    surface.has_maps() ? "which has maps" : "which has none"));
  Stack stack = surface.at(u, v);
  stack.name += fmt::format("@{},{}", to_text(u), to_text(v));
  return stack;
}

// Its files named for a text that lies in the working directory.
std::string toml_of(const Stack& stack) { return to_toml(with_files_relative_to(stack, "")); }

void save_stack(const Stack& stack, const std::string& path) {
  write_file(path,
             to_toml(with_files_relative_to(stack, std::filesystem::path(path).parent_path())));
}

}  // namespace

void bind_stack(py::module_& m) {
  py::class_<Stack>(m, "Stack")
      .def_readonly("name", &Stack::name)
      .def("toml", &toml_of)
      .def("save", &save_stack)
      .def("json",
           [](const Stack& stack) { return to_json(with_files_relative_to(stack, "")).dump(); })
      .def_property_readonly("is_grey", &Stack::is_grey)
      .def_property_readonly("is_half_space", &Stack::is_half_space)
      .def_property_readonly("is_open_below", &Stack::is_open_below)
      .def_property_readonly("is_symmetric", &Stack::is_symmetric_about_z)
      .def_property_readonly("is_reciprocal", &Stack::is_reciprocal);
  m.def("builtin_stack", &builtin_stack);
  m.def("read_stack", &read_stack);
  m.def("parse_stack",
        [](const std::string& text, const std::string& file, const std::string& name) {
          return with_surface_model(parse_stack(text, file, name));
        });
}

}  // namespace lamella
