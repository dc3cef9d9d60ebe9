#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "compare/judge/check_line.h"
#include "compare/library/library_index.h"
#include "compare/request/model_request.h"
#include "compare/request/run_monitor.h"

namespace lamella {

/// A model that stands for the stack of an entry.
struct LibraryClaim {
  const LibraryEntry* entry = nullptr;
  ModelRequest request{};  ///< as the model is asked for on that stack
};

/// The entries that a model claims, in the index's order: those whose stack the catalogue's own
/// test (ModelInfo::applies_to) gives parameters for, none of which contradicts a key that the
/// request gives; and those in `entries`, "NAME[,key=value...]", whichever model it is: keys that
/// are given there and in the request stand, the stack gives the others where both have a name for
/// them. Throws UsageError for a name that is no entry, and where nothing is claimed.
[[nodiscard]] std::vector<LibraryClaim> library_claims(const ModelRequest& request,
                                                       const LibraryIndex& index,
                                                       const std::vector<std::string>& entries);

/// The model against the lobes of an entry: the relative RMSE over the cells of all directions and
/// both sides, with the noise of walks removed and light of walks that were cut where the model
/// fits best, may be `max_error`. The lobe is "all"; of a model whose lobes stand for few orders,
/// those orders. The worst case tells the cell with the largest z too, |difference| over the error
/// of the entry and of the model's projection together. Throws UsageError.
[[nodiscard]] CheckLine check_on_entry(const LibraryClaim& claim,
                                       const std::filesystem::path& folder, double max_error);

/// The same of a model that is there.
[[nodiscard]] CheckLine check_on_entry(const BoundModel& model, const LibraryEntry& entry,
                                       const std::filesystem::path& folder, double max_error);

/// The relative RMSE at which a model passes where nothing else is asked for: that within which
/// `compare` says that it agrees.
inline constexpr double kLibraryMaxError = 0.1;

/// What of a library a model is held against.
struct LibraryUse {
  std::filesystem::path folder{};
  std::vector<std::string> entries{};  ///< NAME[,key=value...] that the model stands for
  double max_error = kLibraryMaxError;
};

/// A line per entry that the model of a request claims (library_claims), in the index's order,
/// until the monitor stops it. Throws UsageError.
[[nodiscard]] std::vector<CheckLine> check_on_library(const ModelRequest& request,
                                                      const LibraryUse& use,
                                                      const RunMonitor& monitor);

/// Makes a model for the stack of an entry, from the keys that the entry was named with.
using ModelOfEntry = std::function<BoundModel(const ModelRequest& entry, const Stack& stack)>;

/// The same of a model that no catalogue has: it claims the entries that `use` names and no others.
[[nodiscard]] std::vector<CheckLine> check_on_library(const std::string& name,
                                                      const ModelOfEntry& make,
                                                      const LibraryUse& use,
                                                      const RunMonitor& monitor);

}  // namespace lamella
