#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "compare/judge/check_line.h"
#include "compare/library/library_index.h"

namespace lamella {

/// Two findings of one entry against each other: every value of every lobe, and every point. By two
/// bounds they may differ by their sum; where walks are among them also by that many standard
/// errors, by Student's t, which one of all the cases exceeds with the probability 1e-3 at most
/// (Bonferroni). Cells of less than kPooledEvents effective events (judge/lobe_sums.h) have no
/// normal errors and are left out, `undecided`; where walks were cut, the light that they held may
/// be missing from any cell. `entry`: named in the worst case.
[[nodiscard]] CheckLine compare_references(const Reference& kept, const Reference& again,
                                           const std::string& entry);

struct LibraryVerification {
  std::filesystem::path folder{};
  std::vector<std::string> only{};  ///< names of entries; empty: of all
  std::size_t sample = 3;           ///< as many of them, drawn with the seed; 0: every one
  ReferenceEffort effort{};         ///< seed: of the draw, and of new walks
  /// Told of every entry that was found again.
  std::function<void(const CheckLine&, const LibraryEntry&)> done{};
};

struct LibraryVerificationResult {
  std::vector<CheckLine> lines{};     ///< per entry that was found again
  std::vector<std::string> broken{};  ///< "FILE: what": files that are not what the index says
  std::size_t entries = 0;            ///< whose files were read
  bool interrupted = false;
};

/// Reads the files of all entries, finds some of them again, by the same method or by walks
/// (effort.walks_only), and compares. Walks have other numbers than those of the entry. Throws
/// UsageError.
[[nodiscard]] LibraryVerificationResult verify_library(const LibraryVerification& verification,
                                                       const RunMonitor& monitor);

}  // namespace lamella
