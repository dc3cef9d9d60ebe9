#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "compare/reproduce/reproduction.h"

namespace lamella {

// Figures of Wang et al. 2022, "SpongeCake: A Layered Microflake Surface Appearance Model".

nlohmann::ordered_json reproduce_spongecake_figure_1(ReproductionContext& context);
nlohmann::ordered_json reproduce_spongecake_figure_7(ReproductionContext& context);
nlohmann::ordered_json reproduce_spongecake_figure_14(ReproductionContext& context);
nlohmann::ordered_json reproduce_spongecake_figure_15(ReproductionContext& context);
nlohmann::ordered_json reproduce_spongecake_figure_16(ReproductionContext& context);

nlohmann::ordered_json reproduce_spongecake_figure_17(ReproductionContext& context);
nlohmann::ordered_json reproduce_spongecake_figure_18(ReproductionContext& context);
nlohmann::ordered_json reproduce_spongecake_figure_19(ReproductionContext& context);

/// All of them, in the paper's order.
[[nodiscard]] std::vector<Reproduction> spongecake_figures();

}  // namespace lamella
