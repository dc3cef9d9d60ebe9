#pragma once

#include <string>
#include <vector>

#include "compare/drawing/picture_format.h"
#include "compare/files/exr_file.h"
#include "compare/judge/comparison.h"
#include "compare/request/truth_request.h"

namespace lamella {

/// Header attributes that tell how a file was made: conventions, resolved stack, seed, walks,
/// estimator, isa, grid. Neither time nor threads nor paths.
[[nodiscard]] std::map<std::string, std::string> file_attributes(
    const TruthRequest& request, const std::vector<RunResult>& runs);

/// The lobes of all runs as the channels of one image.
[[nodiscard]] ExrImage simulation_image(const TruthRequest& request,
                                        const std::vector<RunResult>& runs);

/// One model's comparisons as the channels of one image: truth, its standard error, model,
/// difference and z of every lobe. `model`: it and its parameters, as --model takes them.
[[nodiscard]] ExrImage comparison_image(const TruthRequest& request,
                                        const std::vector<RunResult>& runs,
                                        const std::vector<LobeComparison>& lobes,
                                        const std::string& model);

/// Draws each comparison whose truth or model has energy, a file per format; returns how many were
/// drawn.
int write_comparison_pictures(const std::string& folder, const std::string& model,
                              const std::string& stack, const std::vector<RunResult>& runs,
                              const std::vector<LobeComparison>& lobes,
                              const std::vector<PictureFormat>& formats);

}  // namespace lamella
