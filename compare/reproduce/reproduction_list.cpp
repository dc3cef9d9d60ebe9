#include "compare/reproduce/reproduction_list.h"

#include <algorithm>

#include "compare/reproduce/eon_figures.h"
#include "compare/reproduce/lambert_sphere_figures.h"
#include "compare/reproduce/micrograin_figures.h"
#include "compare/reproduce/spongecake_figures.h"
#include "compare/reproduce/spongecake_lobe_figures.h"
#include "compare/reproduce/vmf_figures.h"

namespace lamella {

const std::vector<Reproduction>& reproductions() {
  static const std::vector<Reproduction> all = [] {
    std::vector<Reproduction> list;
    for (const auto& figures :
         {vmf_figures(), lambert_sphere_figures(), eon_figures(), micrograin_figures(),
          spongecake_figures(), spongecake_lobe_figures()})
      list.insert(list.end(), figures.begin(), figures.end());
    return list;
  }();
  return all;
}

const Reproduction* find_reproduction(const std::string& name) {
  const auto& all = reproductions();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Reproduction& r) { return r.name == name; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace lamella
