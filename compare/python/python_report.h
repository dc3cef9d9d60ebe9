#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "compare/judge/stack_comparison.h"
#include "compare/python/bound_model.h"
#include "compare/report/input_files.h"
#include "compare/request/truth_request.h"

namespace lamella {

/// A comparison as Python holds it, and all that it points to.
struct PythonReport {
  TruthRequest request;
  std::vector<std::shared_ptr<PythonModel>> given;  ///< whose functions and infos `models` use
  std::vector<std::shared_ptr<const ModelInfo>> infos{};  ///< of fitted functions
  std::vector<BoundModel> models;
  InputFiles inputs;
  StackComparison comparison;

  [[nodiscard]] std::string title() const {
    return request.stack.name + ": closed forms against ground truth";
  }
  [[nodiscard]] nlohmann::ordered_json answer() const;
};

/// Writes what `lamella compare -o` does.
void save_report(const PythonReport& report, const std::string& folder,
                 const std::vector<std::string>& pictures);

}  // namespace lamella
