#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "compare/drawing/picture_format.h"
#include "compare/judge/stack_comparison.h"
#include "compare/nearest/target_truths.h"
#include "compare/options/options.h"
#include "compare/report/input_files.h"

namespace lamella {

/// What a fit left over, as a comparison shows it.
struct FitComparison {
  const TargetTruths& target;
  StackComparison comparison;
  const InputFiles& inputs;
  std::vector<PictureFormat> formats;
};

/// Writes the page of a comparison with what was fitted, EXR files, `answer` as fit.json and the
/// tables to the folder of -o, which is there, and says so. `about`: of the page's title.
void write_fit_folder(const Options& options, const FitComparison& found,
                      const nlohmann::ordered_json& answer, const std::string& summary,
                      const std::string& about);

}  // namespace lamella
