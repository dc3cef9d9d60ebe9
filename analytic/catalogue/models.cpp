#include <algorithm>

#include "analytic/coated/coated_model.h"
#include "analytic/coated/openpbr_diffuse.h"
#include "analytic/facets/microfacet_model.h"
#include "analytic/facets/sheen_conty_kulla.h"
#include "analytic/half_space/chandrasekhar.h"
#include "analytic/half_space/lambert_sphere_models.h"
#include "analytic/half_space/lambert_sphere_three_term.h"
#include "analytic/half_space/vmf_diffuse.h"
#include "analytic/layered/micrograin.h"
#include "analytic/layered/single_scattering_model.h"
#include "analytic/layered/spongecake.h"
#include "analytic/model/model.h"
#include "analytic/rough_surface/beckmann_diffuse.h"
#include "analytic/rough_surface/eon.h"
#include "analytic/rough_surface/lambert.h"
#include "analytic/rough_surface/oren_nayar.h"

namespace lamella {

const std::vector<ModelInfo>& models() {
  // clang-format off: one line per model
  static const std::vector<ModelInfo> list = [] {
    std::vector<ModelInfo> all{
        lambert_model(),
        chandrasekhar_model(),
        lambert_sphere_model(),
        lambert_sphere_fast_model(),
        lambert_sphere_three_term_model(),
        lambert_sphere_three_term_pure_model(),
        hapke_lambert_sphere_model(),
        vmf_diffuse_model(),
        vmf_diffuse_printed_model(),
        oren_nayar_full_model(),
        oren_nayar_model(),
        oren_nayar_footnote_model(),
        fujii_qualitative_model(),
        fon_model(),
        eon_model(),
        eon_approx_model(),
        beckmann_diffuse_model(),
        microfacet_model(),
        sheen_conty_kulla_model(),
        openpbr_diffuse_model(),
        single_scattering_model(),
        spongecake_model(),
    };
    // clang-format on
    // Any of them may lie below micrograins, and those too below a coat.
    all.insert(all.end() - 2, micrograin_model(all));
    all.insert(all.end() - 2, coated_model(all));
    return all;
  }();
  return list;
}

const ModelInfo* find_model(std::string_view name) {
  const auto& list = models();
  const auto it = std::find_if(list.begin(), list.end(),
                               [&](const ModelInfo& info) { return info.name == name; });
  return it == list.end() ? nullptr : &*it;
}

}  // namespace lamella
