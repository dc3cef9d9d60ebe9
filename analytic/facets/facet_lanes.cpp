#include "analytic/facets/facet_lanes.h"

#include "analytic/model/batch_lanes.h"

namespace lamella::LAMELLA_ISA {
namespace {

struct FacetStep {
  const FacetFormula& formula;
  int channels;
  void operator()(const double* pairs, double* values) const {
    const auto [xi, yi] = load_numbers(pairs, 0);
    const auto [zi, xo] = load_numbers(pairs, 2);
    const auto [yo, zo] = load_numbers(pairs, 4);
    Doubles f[3];
    formula.evaluate(Vec3<Doubles>{xi, yi, zi}, Vec3<Doubles>{xo, yo, zo}, channels, f);
    if (channels == 1)
      store_values(f[0], f[0], f[0], values);
    else
      store_values(f[0], f[1], f[2], values);
  }
};

}  // namespace

void facet_batch(const FacetFormula* formula, int channels, const double* pairs, double* values,
                 std::size_t count) {
  step_by_step(FacetStep{*formula, channels}, pairs, values, count);
}

}  // namespace lamella::LAMELLA_ISA
