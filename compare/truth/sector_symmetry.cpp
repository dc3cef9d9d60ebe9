#include <cmath>

#include "compare/truth/lobe_table.h"

namespace lamella {
namespace {

// Directions whose projected areas are enough to tell a symmetric matrix, and some more.
constexpr int kDirections = 12;

Direction sample_direction(int k) {
  const double mu = -1 + 2 * (k + 0.5) / kDirections;
  return direction_from_mu_phi(mu, 2.4 * k);
}

// w in the mirror of the vertical plane with that azimuth.
Direction in_mirror(Direction w, double plane) {
  const double c = std::cos(2 * plane), s = std::sin(2 * plane);
  return {c * w.x + s * w.y, s * w.x - c * w.y, w.z};
}

bool is_mirrored(const Stack& stack, double plane) {
  constexpr double kRounding = 1e-9;
  for (const Layer& layer : stack.layers) {
    if (layer.interface) continue;
    for (int k = 0; k < kDirections; ++k) {
      const Direction w = sample_direction(k);
      if (std::abs(sigma(layer.medium, w) - sigma(layer.medium, in_mirror(w, plane))) > kRounding)
        return false;
    }
  }
  return true;
}

}  // namespace

SectorSymmetry::Image SectorSymmetry::image_of(int k, int count) const {
  Image image{k, false};
  if (along && image.sector > count / 2) image = {count - image.sector, !image.turned_over};
  // Two planes: `along` has left the first half.
  if (across && image.sector > count / 4) image = {count / 2 - image.sector, !image.turned_over};
  return image;
}

SectorSymmetry sector_symmetry(const Stack& stack) {
  // The horizontal part of an SGGX matrix, from its projected areas, has the axes that are in
  // question.
  for (const Layer& layer : stack.layers) {
    if (layer.interface || traits(layer.medium).symmetric_about_z) continue;
    const auto square = [&](Direction w) {
      const double area = sigma(layer.medium, w);
      return area * area;
    };
    const double xx = square({1, 0, 0}), yy = square({0, 1, 0});
    const double diagonal = square({std::sqrt(0.5), std::sqrt(0.5), 0});
    const double plane = std::atan2(2 * diagonal - xx - yy, xx - yy) / 2;
    SectorSymmetry found{plane, is_mirrored(stack, plane), false};
    const bool across = is_mirrored(stack, plane + kPi / 2);
    // One plane alone is called `along`.
    if (across && !found.along) return {plane + kPi / 2, true, false};
    found.across = across;
    return found;
  }
  return {};
}

bool LobeTable::mirror_sector(int k) {
  const SectorSymmetry::Image image = symmetry_.image_of(k, kSectors);
  if (image.sector == k) return false;
  const Sector& from = tables_[image.sector];
  Sector& to = tables_[k];
  to.rest = image.turned_over ? from.right : from.rest;
  to.right = image.turned_over ? from.rest : from.right;
  to.energies = from.energies;
  return true;
}

}  // namespace lamella
