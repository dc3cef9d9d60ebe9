#pragma once

#include <string>
#include <vector>

#include "compare/files/exr_file.h"
#include "compare/request/truth_request.h"

namespace lamella {

/// The texels of a mean over a map, as a file records them beside its lobes, so that the run can be
/// repeated without the map's pictures.
struct TexelRecord {
  std::vector<Stack> texels;
  /// Where the solver found the mean: GroundTruth::texel_ends, of each of the texels.
  std::vector<TruthRequest::SolverEnd> ends;
};

/// Writes what the request's mean is of, if it is one: lamella.texel_stacks, every different stack
/// once after a line of kTexelLine, lamella.texel_places, which of them each texel is, and
/// lamella.texel_ends. Where `ends` are fewer than the texels a stop left the mean of these alone.
void record_texels(ExrImage& image, const TruthRequest& request,
                   const std::vector<TruthRequest::SolverEnd>& ends);

/// Nothing where the file is no mean. Throws UsageError, naming the file, where it is a mean of
/// texels that it does not have, or they are damaged; StackFileError where one of the stacks is.
[[nodiscard]] TexelRecord read_texels(const ExrImage& image, const std::string& path);

}  // namespace lamella
