#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "compare/files/growing_npz.h"
#include "compare/report/input_files.h"
#include "compare/samples/sample_stream.h"

namespace lamella {

/// Samples as an archive of NumPy arrays, for n rows:
///
///     w_i, w_o   [n, 3] float32    unit vectors that point away from the stack
///     weight     [n, channels] float32
///     order      [n] uint32
///     side       [n] int8          1 reflected, -1 transmitted; deltas 2 and -2
///     walks      uint64            how many began: the sum of weights / walks is the energy
///     directions [d, 3] float64, direction_walks, direction_rows [d] uint64
///                                  rows stand direction by direction; d = 0 where w_i was drawn
///     lamella    text              JSON: stack, seed and all else that the rows depend on
class SampleFile {
 public:
  /// Throws OutputError, as do all.
  SampleFile(const std::filesystem::path& path, int channels);
  void add(const SampleChunk& chunk);
  /// Rows whose checksums are not known yet.
  void add(const WalkSamples& samples);
  /// Writes the file. Returns its size in bytes.
  std::uint64_t finish(const SampleRequest& request, const std::vector<SampleTotals>& totals,
                       const InputFiles& inputs);

 private:
  std::filesystem::path path_;
  GrowingNpz file_;
};

/// What the rows depend on: the text `lamella` of a file in `folder`.
[[nodiscard]] nlohmann::ordered_json samples_about(const SampleRequest& request,
                                                   const InputFiles& inputs,
                                                   const std::filesystem::path& folder);

}  // namespace lamella
