#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "compare/preview/preview.h"
#include "compare/report/input_files.h"
#include "compare/request/interrupt.h"
#include "compare/request/model_request.h"
#include "compare/truth/lobe_table.h"

namespace lamella {

/// What shines in a preview.
struct PreviewLighting {
  double lamp_theta = 45, lamp_phi = 45;  ///< degrees
  Environment environment{};
};

/// One view of a preview, drawn: the truth first, then every model.
struct PreviewResult {
  PreviewView view;
  std::vector<PreviewColumn> columns;
  /// sphere_lamp, plane_environment, ...
  [[nodiscard]] std::string name() const;
};

/// Sphere and plane, under the lamp and under the environment, `size` pixels across; fewer once
/// `stop` is set. Models have distinct names and labels. Runs in the calling thread's task arena.
[[nodiscard]] std::vector<PreviewResult> preview_views(const LobeTable& truth,
                                                       const std::vector<BoundModel>& models,
                                                       const PreviewLighting& lighting, int size,
                                                       const StopFlag* stop);

/// Writes `prefix`NAME.exr and a picture per format of every view. `inputs`: what the EXR names as
/// the files that were read. Throws OutputError.
void write_preview_files(const std::string& prefix, const std::vector<PreviewResult>& views,
                         const LobeTable& truth, const Stack& stack,
                         const PreviewLighting& lighting, const std::vector<PictureFormat>& formats,
                         const InputFiles& inputs);

/// For an answer: per view its scene and light, and the mean luminance of each picture.
[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<PreviewResult>& views);

/// For a page: per view a title, the pictures and their differences from the truth as data: URLs of
/// PNG, and the scale of the differences with its colours.
[[nodiscard]] nlohmann::ordered_json preview_page_details(const std::vector<PreviewResult>& views,
                                                          const LobeTable& truth,
                                                          const PreviewLighting& lighting);

/// A line per picture for a table.
[[nodiscard]] std::string preview_table(const std::vector<PreviewResult>& views);

}  // namespace lamella
