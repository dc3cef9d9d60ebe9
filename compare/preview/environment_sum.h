#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "compare/preview/environment.h"

namespace lamella {

/// The sum of a lobe over the tree of an environment: nodes are descended into until the lobe is
/// smooth over them; blocks that are texels, whose radiance is constant, are halved further.
///
/// Lobe has: is_large(middle, extent), an optional<bool>, nothing where a rectangle counts nothing;
/// and add(flux, centroid).
template <class Lobe>
class EnvironmentSum {
 public:
  EnvironmentSum(const Environment& environment, Lobe& lobe)
      : environment_(environment), lobe_(lobe) {}

  void visit(const Environment::Node& node) {
    if (node.flux[0] == 0 && node.flux[1] == 0 && node.flux[2] == 0) return;
    const auto large = lobe_.is_large(environment_.middle(node), environment_.extent(node));
    if (!large) return;
    if (*large && node.children >= 0) {
      const auto children = static_cast<std::size_t>(node.children);
      visit(environment_.nodes()[children]);
      visit(environment_.nodes()[children + 1]);
      return;
    }
    const Rgb flux(node.flux[0], node.flux[1], node.flux[2]);
    if (*large && environment_.blocks_are_texels())
      halve(flux, environment_.longitude(node.column),
            environment_.longitude(node.column + node.columns), environment_.polar_angle(node.row),
            environment_.polar_angle(node.row + node.rows));
    else
      lobe_.add(flux, {node.centroid[0], node.centroid[1], node.centroid[2]});
  }

 private:
  // A part of a block, whose radiance is constant.
  void part(Rgb flux, double left, double right, double top, double bottom) {
    const Direction middle = lat_long_direction((left + right) / 2, (top + bottom) / 2);
    const double sine =
        top < kPi / 2 && bottom > kPi / 2 ? 1 : std::max(std::sin(top), std::sin(bottom));
    const auto large = lobe_.is_large(middle, {bottom - top, (right - left) * sine});
    if (!large) return;
    if (*large)
      halve(flux, left, right, top, bottom);
    else
      lobe_.add(flux, middle);
  }

  void halve(Rgb flux, double left, double right, double top, double bottom) {
    const double sine = std::sin((top + bottom) / 2);
    if (bottom - top >= (right - left) * sine) {
      const double between = (top + bottom) / 2;
      const double share = (std::cos(top) - std::cos(between)) / (std::cos(top) - std::cos(bottom));
      part(share * flux, left, right, top, between);
      part((1 - share) * flux, left, right, between, bottom);
    } else {
      const double between = (left + right) / 2;
      part(0.5 * flux, left, between, top, bottom);
      part(0.5 * flux, between, right, top, bottom);
    }
  }

  const Environment& environment_;
  Lobe& lobe_;
};

}  // namespace lamella
