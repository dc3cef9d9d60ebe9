#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "compare/judge/check_line.h"
#include "compare/library/library_index.h"
#include "compare/request/model_request.h"

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

/// The relative RMSE at which a model passes where nothing else is asked for: that within which
/// `compare` says that it agrees.
inline constexpr double kLibraryMaxError = 0.1;

}  // namespace lamella
