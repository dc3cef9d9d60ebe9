#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "compare/reproduce/reproduction.h"

namespace lamella {

// Figures of d'Eon and Weidlich 2024, "VMF Diffuse: A unified rough diffuse BRDF".

nlohmann::ordered_json reproduce_vmf_figure_1(ReproductionContext& context);
nlohmann::ordered_json reproduce_vmf_figure_2(ReproductionContext& context);
nlohmann::ordered_json reproduce_vmf_figure_3(ReproductionContext& context);
nlohmann::ordered_json reproduce_vmf_figure_4(ReproductionContext& context);
nlohmann::ordered_json reproduce_vmf_figure_5(ReproductionContext& context);
nlohmann::ordered_json reproduce_vmf_figure_6(ReproductionContext& context);
nlohmann::ordered_json reproduce_vmf_figure_7(ReproductionContext& context);
nlohmann::ordered_json reproduce_vmf_figure_8(ReproductionContext& context);
nlohmann::ordered_json reproduce_vmf_figure_9(ReproductionContext& context);
nlohmann::ordered_json reproduce_vmf_figure_10(ReproductionContext& context);
nlohmann::ordered_json reproduce_vmf_figure_11(ReproductionContext& context);
nlohmann::ordered_json reproduce_vmf_figure_12(ReproductionContext& context);

/// All of them, in the paper's order.
[[nodiscard]] std::vector<Reproduction> vmf_figures();

}  // namespace lamella
