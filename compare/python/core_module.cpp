#include "compare/python/bindings.h"

PYBIND11_MODULE(_core, m) {
  m.doc() = "The compiled part of lamella; import lamella instead.";
  m.attr("__version__") = LAMELLA_VERSION;
  lamella::bind_errors(m);
  lamella::bind_lists(m);
  lamella::bind_stack(m);
  lamella::bind_model(m);
  lamella::bind_lobes(m);
  lamella::bind_truth(m);
  lamella::bind_samples(m);
  lamella::bind_report(m);
  lamella::bind_furnace(m);
  lamella::bind_formats(m);
  lamella::bind_family(m);
  lamella::bind_fit(m);
  lamella::bind_check(m);
  lamella::bind_library(m);
}
