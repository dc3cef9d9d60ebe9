#include "analytic/half_space/three_term_constants.h"

#include <fmt/format.h>

namespace lamella {

double three_term_m(double l, double n) { return (n - l * l) * 64 / 45; }

ThreeTermConstants three_term_constants(const ThreeTermHalfSpace& half_space) {
  ThreeTermConstants found{half_space.mode_0_constants(), half_space.l(),
                           three_term_m(half_space.l(), half_space.n())};
  for (double& constant : found.mode_0) constant /= 2;  // eq. 36 has half of them
  return found;
}

std::vector<PartInfo> constant_parts(
    const std::string& how, const std::function<ThreeTermConstants(double albedo)>& constants) {
  std::vector<PartInfo> parts;
  for (std::size_t k = 0; k < 6; ++k)
    parts.push_back(part_of_albedo(
        fmt::format("constant_{}", "abcdef"[k]),
        fmt::format("{} of azimuthal mode 0, eq. 36, {}; of no direction", "ABCDEF"[k], how),
        [=](double c, double) { return constants(c).mode_0[k]; }));
  for (const bool is_l : {true, false})
    parts.push_back(part_of_albedo(
        is_l ? "constant_l" : "constant_m",
        fmt::format("{} of azimuthal mode 1, eq. 27, {}; of no direction", is_l ? 'l' : 'm', how),
        [=](double c, double) { return is_l ? constants(c).l : constants(c).m; }));
  return parts;
}

}  // namespace lamella
