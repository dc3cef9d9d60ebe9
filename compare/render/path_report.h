#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "compare/drawing/picture_format.h"
#include "compare/preview/preview.h"
#include "compare/render/path_picture.h"
#include "compare/report/input_files.h"

namespace lamella {

/// A traced picture and its name; the first of several is the truth by walks. `label`: what people
/// read; empty: the name.
struct NamedPicture {
  std::string name;
  PathPicture picture;
  std::string label{};
  [[nodiscard]] const std::string& told() const { return label.empty() ? name : label; }
};

/// How far a picture is from the first: relative mean square errors (relative_difference), and
/// FLIP.
struct TracedError {
  double noise = 0;       ///< of this picture
  double difference = 0;  ///< from the truth, noise of both in it
  /// Without the noise of both: bias^2, not below 0; `bias_error`: its standard error, as if every
  /// pixel were independent.
  double bias = 0;
  double bias_error = 0;
  double flip = 0;  ///< flip_error of preview.h, in [0, 1]; noise of both in it
};
[[nodiscard]] TracedError traced_error(const PathPicture& truth, const PathPicture& picture);

/// As it is drawn beside others.
[[nodiscard]] PreviewColumn column_of(const NamedPicture& named);

/// What the files and answers tell of a run.
struct PathRun {
  std::string stack_name, stack, shape;  ///< name, text (TOML, or "maps"), --shape
  int depth = 4;
  std::optional<double> equal_time{};
};

/// A line per picture.
[[nodiscard]] std::string picture_table(const std::vector<NamedPicture>& pictures);
[[nodiscard]] nlohmann::ordered_json to_json(const std::vector<NamedPicture>& pictures,
                                             const PathRun& run);
/// picture.exr (means, variances of the means, numbers of samples), picture.png (side by side with
/// differences) and, where there was an equal time, error.png (speed against error).
void write_path_files(const std::string& folder, const std::vector<NamedPicture>& pictures,
                      const PathRun& run, const std::vector<PictureFormat>& formats,
                      const InputFiles& inputs);

}  // namespace lamella
