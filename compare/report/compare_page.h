#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "compare/judge/comparison.h"
#include "volume/run/simulation.h"

namespace lamella {

/// float32 values, little-endian, in base64: how maps stand in a page.
[[nodiscard]] std::string base64_floats(const std::vector<double>& values);

/// The data that the page of a comparison shows beside its JSON: the grid, the ledgers of the runs
/// and the maps of truth, standard error and every model, [channel][cell]. `models`: the
/// comparisons of each model, in the order of the answer's models.
[[nodiscard]] nlohmann::ordered_json compare_page_details(
    const std::vector<RunResult>& runs, const std::vector<std::vector<LobeComparison>>& models);

}  // namespace lamella
