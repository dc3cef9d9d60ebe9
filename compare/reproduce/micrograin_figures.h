#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "compare/reproduce/reproduction.h"

namespace lamella {

// Figures of Lucas et al. 2023, "A Micrograin BSDF Model for the Rendering of Porous Layers".

nlohmann::ordered_json reproduce_micrograin_figure_4(ReproductionContext& context);
nlohmann::ordered_json reproduce_micrograin_figure_5(ReproductionContext& context);
nlohmann::ordered_json reproduce_micrograin_figure_9(ReproductionContext& context);
nlohmann::ordered_json reproduce_micrograin_figure_10(ReproductionContext& context);
nlohmann::ordered_json reproduce_micrograin_figure_11(ReproductionContext& context);
nlohmann::ordered_json reproduce_micrograin_figure_12(ReproductionContext& context);
nlohmann::ordered_json reproduce_micrograin_figure_13(ReproductionContext& context);
nlohmann::ordered_json reproduce_micrograin_figure_14(ReproductionContext& context);

/// All of them, in the paper's order.
[[nodiscard]] std::vector<Reproduction> micrograin_figures();

}  // namespace lamella
