#include "analytic/model/grazing_pair.h"

#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

constexpr double kFartherOut = 1e-120;
constexpr double kAgree = 1e-9, kNothing = 1e-10;

Direction at_height(Direction w, double mu) {
  w.z = std::copysign(mu, w.z);
  return w;
}

}  // namespace

bool grazes_twice(Direction wi, Direction wo) {
  return std::abs(wi.z) < kGrazingLimit && std::abs(wo.z) < kGrazingLimit;
}

std::optional<Rgb> limit_where_both_graze(const std::function<Rgb(Direction wi, Direction wo)>& f,
                                          Direction wi, Direction wo) {
  wi = with_grazing_limit(wi);
  wo = with_grazing_limit(wo);
  const Rgb limit = f(wi, wo);
  if (!std::isfinite(limit.r + limit.g + limit.b)) return std::nullopt;
  const Direction above_i = at_height(wi, kFartherOut), above_o = at_height(wo, kFartherOut);
  for (const Rgb& v : {f(above_i, wo), f(wi, above_o), f(above_i, above_o)})
    for (int c = 0; c < 3; ++c) {
      const double most = std::max(std::abs(v[c]), std::abs(limit[c]));
      if (!(std::abs(v[c] - limit[c]) <= std::max(kAgree * most, kNothing))) return std::nullopt;
    }
  return limit;
}

}  // namespace lamella
