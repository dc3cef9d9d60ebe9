#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "compare/reproduce/reproduction.h"

namespace lamella {

// Figures of d'Eon 2021, "An analytic BRDF for materials with spherical Lambertian scatterers".

nlohmann::ordered_json reproduce_lambert_sphere_dilute(ReproductionContext& context);
nlohmann::ordered_json reproduce_lambert_sphere_figure_3(ReproductionContext& context);
nlohmann::ordered_json reproduce_lambert_sphere_figure_4(ReproductionContext& context);
nlohmann::ordered_json reproduce_lambert_sphere_figure_5(ReproductionContext& context);
nlohmann::ordered_json reproduce_lambert_sphere_figure_6(ReproductionContext& context);
nlohmann::ordered_json reproduce_lambert_sphere_figure_7(ReproductionContext& context);
nlohmann::ordered_json reproduce_lambert_sphere_figure_8(ReproductionContext& context);
nlohmann::ordered_json reproduce_lambert_sphere_figure_10(ReproductionContext& context);
nlohmann::ordered_json reproduce_lambert_sphere_figure_11(ReproductionContext& context);
nlohmann::ordered_json reproduce_lambert_sphere_figure_12(ReproductionContext& context);
nlohmann::ordered_json reproduce_lambert_sphere_figure_13(ReproductionContext& context);

/// All of them, in the paper's order.
[[nodiscard]] std::vector<Reproduction> lambert_sphere_figures();

}  // namespace lamella
