#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compare/judge/model_check.h"
#include "compare/request/model_request.h"

namespace lamella {

/// The requests that a check of a model over its parameters makes, at most `most`, the first being
/// `request` itself. The others keep the keys that `request` gives, and vary the rest: the white
/// model (is_white), all shapes (is_shape) at the lower end, the middle and the upper end of their
/// ranges, each shape at each of the three and each choice alone, black and coloured; then corners
/// of all these at random. Keys of a surface below (ModelInfo::selected_prefix) stay at their
/// defaults or white. The same for equal arguments.
[[nodiscard]] std::vector<ModelRequest> configurations_of(const ModelInfo& info,
                                                          const ModelRequest& request, int most,
                                                          std::uint64_t seed);

/// The request as --model takes it.
[[nodiscard]] std::string to_request(const ModelRequest& request);

/// The same as models to check. `stack`: of a model that is built from one, which is checked as it
/// is asked for. Throws UsageError where `request` itself is refused; others that the model refuses
/// are counted by the check.
[[nodiscard]] std::vector<CheckConfiguration> configurations_to_check(
    const ModelInfo& info, const ModelRequest& request, const std::optional<Stack>& stack, int most,
    std::uint64_t seed);

}  // namespace lamella
