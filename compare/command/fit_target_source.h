#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "compare/nearest/target_truths.h"
#include "compare/options/options.h"
#include "compare/request/run_monitor.h"

namespace lamella {

/// What TARGET of fit turned out to be: a file, a closed form, or else a stack.
struct FitTargetSource {
  std::vector<std::filesystem::path> files{};  ///< that are read, grids of the stack apart
  std::optional<BoundModel> model{};
  Stack stack{};
};
[[nodiscard]] FitTargetSource fit_target_source(const Options& options);
/// Its lobes, along the directions of the options or along others in their place. Throws UsageError
/// for options that it has no use for.
[[nodiscard]] TargetTruths target_of(const Options& options, const FitTargetSource& source,
                                     const RunMonitor& monitor,
                                     const std::vector<Direction>& others = {});
/// Whether it has lobes along other directions than those: a file of lobes has not.
[[nodiscard]] bool has_other_directions(const Options& options);

}  // namespace lamella
