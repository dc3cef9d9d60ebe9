#pragma once

#include <pybind11/pybind11.h>

namespace lamella {

// What the module `lamella._core` holds, one function per file. The package's Python files
// (lamella/) are what users see: they complete arguments, broadcast arrays and document.

void bind_errors(pybind11::module_& m);
void bind_lists(pybind11::module_& m);
void bind_stack(pybind11::module_& m);
void bind_model(pybind11::module_& m);
void bind_lobes(pybind11::module_& m);
void bind_truth(pybind11::module_& m);
void bind_samples(pybind11::module_& m);
void bind_report(pybind11::module_& m);
void bind_furnace(pybind11::module_& m);
void bind_formats(pybind11::module_& m);
void bind_family(pybind11::module_& m);
void bind_fit(pybind11::module_& m);
void bind_check(pybind11::module_& m);
void bind_library(pybind11::module_& m);

}  // namespace lamella
