#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compare/report/input_files.h"
#include "compare/report/lobe_set.h"
#include "compare/request/truth_request.h"
#include "compare/truth/estimator_choice.h"

namespace lamella {

/// Lobes as Python holds them, and how they were found; arrays that Python sees are views of them.
struct PythonLobes {
  LobeSet set;
  /// Of lobes that were simulated: what was asked for, the runs less their lobes, files that were
  /// read.
  std::optional<TruthRequest> request{};
  std::vector<RunResult> runs{};
  InputFiles inputs{};
  std::string answer = "null";  ///< JSON, as the command line's
  std::string estimator{};      ///< which and why, in words
  bool interrupted = false;
  bool bounded = false;  ///< errors are bounds; of lobes that were simulated the runs tell
};

/// Takes the lobes out of the runs.
[[nodiscard]] std::unique_ptr<PythonLobes> simulated_lobes(TruthRequest request,
                                                           std::vector<RunResult> runs,
                                                           const EstimatorChoice& choice,
                                                           InputFiles inputs, bool interrupted);

}  // namespace lamella
