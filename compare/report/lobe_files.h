#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "compare/drawing/picture_format.h"
#include "compare/files/exr_file.h"
#include "compare/judge/comparison.h"
#include "compare/report/input_files.h"
#include "compare/request/truth_request.h"

namespace lamella {

/// Header attributes that tell how a file was made: conventions, resolved stack, seed, walks,
/// estimator, isa, grid. Neither time nor threads; files are named as the request's stack names
/// them (see with_files_relative_to).
[[nodiscard]] std::map<std::string, std::string> file_attributes(
    const TruthRequest& request, const std::vector<RunResult>& runs);

/// The lobes of all runs as the channels of one image.
[[nodiscard]] ExrImage simulation_image(const TruthRequest& request,
                                        const std::vector<RunResult>& runs);

/// Adds to it the standard errors that a sample of texels leaves of a map's mean
/// (Truth::map_error), channels with the part "map_error"; nothing where there are none.
void add_map_errors(ExrImage& image, const std::vector<RunResult>& map_errors);

/// One model's comparisons as the channels of one image: truth, its standard error, model,
/// difference and z of every lobe. `model`: it and its parameters, as --model takes them.
[[nodiscard]] ExrImage comparison_image(const TruthRequest& request,
                                        const std::vector<RunResult>& runs,
                                        const std::vector<LobeComparison>& lobes,
                                        const std::string& model);

/// Records the files that the run read, named for an image that lies in `folder`:
/// "lamella.files"; nothing where there are none.
void record_files(ExrImage& image, const InputFiles& inputs, const std::filesystem::path& folder);

/// The request with its stack's files named for an image that lies in `folder`.
[[nodiscard]] TruthRequest named_for_image(TruthRequest request,
                                           const std::filesystem::path& folder);

/// Draws each comparison whose truth or model has energy, a file per format; returns how many were
/// drawn. `model`: in the names of files; `label`: in titles.
int write_comparison_pictures(const std::string& folder, const std::string& model,
                              const std::string& label, const std::string& stack,
                              const std::vector<RunResult>& runs,
                              const std::vector<LobeComparison>& lobes,
                              const std::vector<PictureFormat>& formats);

}  // namespace lamella
