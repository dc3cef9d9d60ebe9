#include "compare/reproduce/reproduction_list.h"

#include <algorithm>
#include <string>

#include "compare/reproduce/eon_figures.h"
#include "compare/reproduce/lambert_sphere_figures.h"
#include "compare/reproduce/micrograin_figures.h"
#include "compare/reproduce/spongecake_figures.h"
#include "compare/reproduce/spongecake_lobe_figures.h"
#include "compare/reproduce/vmf_figures.h"

namespace lamella {

namespace {

// "spongecake_figure_7": 7.
int number_of(const Reproduction& figure) {
  return std::stoi(figure.name.substr(figure.name.rfind('_') + 1));
}

// Both lists of one paper, by the figures' numbers.
std::vector<Reproduction> all_spongecake_figures() {
  std::vector<Reproduction> list = spongecake_figures();
  for (const Reproduction& figure : spongecake_lobe_figures()) list.push_back(figure);
  std::sort(list.begin(), list.end(),
            [](const auto& a, const auto& b) { return number_of(a) < number_of(b); });
  return list;
}

}  // namespace

const std::vector<Reproduction>& reproductions() {
  static const std::vector<Reproduction> all = [] {
    std::vector<Reproduction> list;
    for (const auto& figures : {vmf_figures(), lambert_sphere_figures(), eon_figures(),
                                micrograin_figures(), all_spongecake_figures()})
      list.insert(list.end(), figures.begin(), figures.end());
    return list;
  }();
  return all;
}

namespace {

// Figures that another one has with it.
struct OtherName {
  const char *name, *is;
};
constexpr OtherName kOtherNames[] = {{"lambert_sphere_figure_1", "lambert_sphere_dilute"},
                                     {"lambert_sphere_figure_9", "lambert_sphere_figure_10"},
                                     {"eon_figure_2", "eon_figure_1"}};

}  // namespace

const Reproduction* find_reproduction(const std::string& asked) {
  std::string name = asked;
  for (const OtherName& other : kOtherNames)
    if (asked == other.name) name = other.is;
  const auto& all = reproductions();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const Reproduction& r) { return r.name == name; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace lamella
