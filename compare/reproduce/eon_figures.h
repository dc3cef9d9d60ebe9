#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "compare/reproduce/reproduction.h"

namespace lamella {

// Figures of Portsmouth, Kutz and Hill 2025, "EON: A practical energy-preserving rough diffuse
// BRDF".

nlohmann::ordered_json reproduce_eon_figure_1(ReproductionContext& context);
nlohmann::ordered_json reproduce_eon_figure_3(ReproductionContext& context);
nlohmann::ordered_json reproduce_eon_figure_4(ReproductionContext& context);
nlohmann::ordered_json reproduce_eon_figure_5(ReproductionContext& context);
nlohmann::ordered_json reproduce_eon_figure_6(ReproductionContext& context);
nlohmann::ordered_json reproduce_eon_figure_7(ReproductionContext& context);
nlohmann::ordered_json reproduce_eon_figure_8(ReproductionContext& context);
nlohmann::ordered_json reproduce_eon_figure_9(ReproductionContext& context);
nlohmann::ordered_json reproduce_eon_figure_10(ReproductionContext& context);
nlohmann::ordered_json reproduce_eon_figure_11(ReproductionContext& context);
nlohmann::ordered_json reproduce_eon_figure_13(ReproductionContext& context);
nlohmann::ordered_json reproduce_eon_table_1(ReproductionContext& context);

/// All of them, in the paper's order.
[[nodiscard]] std::vector<Reproduction> eon_figures();

}  // namespace lamella
