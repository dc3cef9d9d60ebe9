#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "compare/options/options.h"
#include "compare/ranks/ranks.h"
#include "compare/samples/sample_stream.h"

namespace lamella {

/// Walks one by one of a stack, as the options say.
[[nodiscard]] SampleRequest sample_request(const Options& options, const Stack& stack);
/// The walks of one direction, or of all that drew theirs, as the answer has them.
[[nodiscard]] nlohmann::ordered_json to_json(const SampleTotals& totals,
                                             const SampleRequest& request);
/// The samples of all ranks, pieces in turns; rank 0 writes them as `finish` does, which finds each
/// piece at the monitor's keeper. Pieces that wait for an earlier one are in rank 0's memory.
int samples_by_ranks(const SampleRequest& request, const RunMonitor& monitor, Ranks& ranks,
                     const std::function<int(const RunMonitor&)>& finish);
/// A data set: a file per stack.
int sample_set_command(const Options& options, const std::vector<std::string>& stacks);

}  // namespace lamella
