#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <memory>

#include "compare/judge/pair_truth.h"
#include "compare/python/arrays.h"
#include "compare/python/bindings.h"
#include "compare/python/keyword_options.h"
#include "compare/python/python_lobes.h"
#include "compare/python/work.h"
#include "compare/request/errors.h"
#include "compare/truth/ground_truth.h"

namespace lamella {

namespace py = pybind11;

namespace {

// Lobes and the warnings.
py::tuple simulate(const Stack& stack, const py::dict& keywords, const py::object& show) {
  const Options options = options_of(keywords);
  const TruthRequest request = truth_request(options, stack);
  std::unique_ptr<PythonLobes> lobes;
  WorkEnd end = do_work(options.threads, show, [&](const RunMonitor& monitor) {
    InputFiles inputs(request.stack);
    GroundTruth truth(request, Estimator::analog, monitor);
    std::vector<RunResult> runs;
    for (std::size_t k = 0; truth.goes_on(k); ++k) runs.push_back(truth.find(k).run);
    inputs.check();
    lobes = simulated_lobes(request, std::move(runs), truth.choice(), std::move(inputs),
                            truth.is_stopped());
  });
  return py::make_tuple(std::move(lobes), end.warnings);
}

// f and its error, [n, channels], whether they are less than what was asked for, and the warnings.
py::tuple truth(const Stack& stack, const Doubles1& wi, const Doubles1& wo,
                const py::dict& keywords, const py::object& show) {
  const Options options = options_of(keywords);
  if (options.estimator == "analog")
    throw UsageError(
        "truth: key \"estimator\": found \"analog\", which counts light in cells and never meets a "
        "point; allowed: auto, next-event, deterministic");
  const TruthRequest request = truth_request(options, stack);
  const std::vector<Direction> in = directions_of(wi, "wi"), out = directions_of(wo, "wo");
  std::vector<DirectionPair> pairs;
  for (std::size_t k = 0; k < in.size(); ++k) pairs.push_back({in[k], out[k]});
  PairTruth found;
  int channels = stack.is_grey() ? 1 : 3;
  WorkEnd end = do_work(options.threads, show, [&](const RunMonitor& monitor) {
    if (stack.has_grid()) channels = plan_of(request).channels;
    for (const DirectionPair& pair : pairs)
      if (pair.wi.z < 0 && !stack.is_open_below())
        throw UsageError(stack.substrate
                             ? "truth: light from below, which meets an opaque substrate; allowed: "
                               "theta_i in [0, 90], mu_i >= 0"
                             : "truth: light from below, which cannot come through a half space; "
                               "allowed: theta_i in [0, 90], mu_i >= 0");
    found = truth_of_pairs(request, pairs, monitor);
  });
  return py::make_tuple(array_of(found.f, channels), array_of(found.error, channels),
                        end.interrupted, end.warnings);
}

}  // namespace

void bind_truth(py::module_& m) {
  m.def("simulate", &simulate);
  m.def("truth", &truth);
}

}  // namespace lamella
