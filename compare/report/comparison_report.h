#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "compare/drawing/picture_format.h"
#include "compare/judge/stack_comparison.h"
#include "compare/report/input_files.h"

namespace lamella {

/// The answer of `compare`, without previews.
[[nodiscard]] nlohmann::ordered_json comparison_json(const TruthRequest& request,
                                                     const StackComparison& comparison);

/// The data that its page shows beside the answer: the maps of the truth and of every model.
[[nodiscard]] nlohmann::ordered_json comparison_details(const StackComparison& comparison);

/// The tables: a headline, then a row per lobe of every model.
[[nodiscard]] std::string comparison_summary(const TruthRequest& request,
                                             const StackComparison& comparison);

/// Writes truth.exr, an EXR per model and a picture per lobe and format to a folder that is there;
/// returns the number of pictures. `inputs`: the files that the run has read. Throws OutputError.
int write_comparison_files(const std::string& folder, const TruthRequest& request,
                           const StackComparison& comparison,
                           const std::vector<PictureFormat>& formats, const InputFiles& inputs);

}  // namespace lamella
