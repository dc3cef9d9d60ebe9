#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace lamella {

/// A reader of what comes from outside, for random inputs.
struct InputReader {
  std::string name;
  /// Reads the bytes. Returns whether they were taken; they may be refused in the reader's own kind
  /// of error. Any other exception, crash or endless loop is a failure.
  bool (*read)(const std::string& bytes);
  /// Whole inputs as the program writes them: what random changes begin with.
  std::vector<std::string> (*seeds)();
  int changes;  ///< changed inputs in the ordinary tests: more of quick readers
};

/// Stacks, pairs of directions, EXR, PNG, JPEG, OBJ, VDB, part files and checkpoints, batches of
/// walks, solved runs, values at pairs, tensor files, MERL, NumPy archives, the index of a library,
/// settings, models. Where a checksum guards the content the reader also gets it with a right one.
[[nodiscard]] const std::vector<InputReader>& input_readers();

}  // namespace lamella
