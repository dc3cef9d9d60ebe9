#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace lamella {

/// The table of a sweep's answer (schema/sweep.json): a row per point with the values of its
/// parameters. Of compare, each model's largest relative RMSE without noise over the incident
/// directions and sides, all orders together; of furnace, the energies farthest from 1 and the
/// verdict. At most 100 columns wide where the names allow it: models that do not fit beside each
/// other follow below. Empty where no point has an answer.
[[nodiscard]] std::string sweep_table(const nlohmann::ordered_json& sweep);

}  // namespace lamella
