// Which walks lanes take, and why not the others.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "volume/lanes/lane_run.h"
#include "volume/lanes/lane_setting.h"
#include "volume/lanes/lane_ways.h"
#include "volume/plan/plan.h"

namespace lamella {
namespace {

constexpr double kDeepest = 1e4;  // a place in the bulk is rounded to 1e-3 of a mean free path
constexpr double kNarrowestSggx = 0.02;  // smallest diagonal entry of A, over the largest
constexpr double kNarrowestVmf = 1e-3;   // alpha
constexpr double kNarrowestHg = 0.97;    // at 0.99 thin layers are off by 5e-5
constexpr double kMostGrazingPoint = 1e-4;
constexpr std::uint64_t kMostTabulatedOrders = kThinnedMaxOrder;

// A medium that walks on lanes has an overload here; any other walks in double.
template <class M>
std::optional<std::string> why_not_medium(const M&, double) {
  return "lanes have no kernel for this medium";
}
std::optional<std::string> why_not_medium(const LambertSphere&, double) { return std::nullopt; }
std::optional<std::string> why_not_medium(const Rayleigh&, double) { return std::nullopt; }
std::optional<std::string> why_not_medium(const HenyeyGreenstein& m, double) {
  if (std::abs(m.g) > kNarrowestHg) return "so narrow a forward peak asks for double";
  return std::nullopt;
}
std::optional<std::string> why_not_flakes(const Sggx& ndf, double) {
  const auto& a = ndf.matrix();
  const auto [least, most] = std::minmax({a.a00, a.a11, a.a22});
  if (least < kNarrowestSggx * most || most > 1e3 || least < 1e-3)
    return "SGGX flakes this narrow ask for double";
  return std::nullopt;
}
std::optional<std::string> why_not_flakes(const Vmf& ndf, double) {
  if (ndf.alpha() < kNarrowestVmf) return "vMF flakes this narrow ask for double";
  return std::nullopt;
}
template <class Ndf>
std::optional<std::string> why_not_medium(const MirrorFlakes<Ndf>& m, double depth) {
  return why_not_flakes(m.ndf, depth);
}
template <class Ndf>
std::optional<std::string> why_not_medium(const LambertFlakes<Ndf>& m, double depth) {
  return why_not_flakes(m.ndf, depth);
}

// Interfaces of a stack, and what is below them, that lanes do not know.
constexpr double kSmoothest = 1e-4;  // alpha
constexpr double kThinnestFilm = 0.01;
std::optional<std::string> why_not_boundaries(const Stack& stack, const Plan& plan) {
  if (stack.substrate && !stack.substrate->model.empty())
    return fmt::format("lanes have no kernel for a substrate that reflects by {}",
                       stack.substrate->model);
  for (const Layer& layer : stack.layers) {
    if (!layer.interface) continue;
    const Facets& facets = layer.interface->facets;
    if (facets.shape == FacetShape::smooth) continue;
    if (layer.interface->multiple)
      return "the walk between the facets of an interface (scattering = \"multiple\") has no "
             "kernel "
             "on lanes";
    if (std::min(facets.alpha_x, facets.alpha_y) < kSmoothest)
      return fmt::format("facets of alpha below {:g} ask for double", kSmoothest);
  }
  if (plan.max_order > kMostBoundedOrder)
    return "orders above 1e8 are not counted on lanes through interfaces";
  // Between smooth interfaces light can be trapped: there its ways there and back are skipped in
  // double.
  const BoundaryStack bounded(stack, plan);
  const auto is_smooth = [&](int k) {
    return bounded.boundaries[k] && bounded.boundaries[k]->is_smooth();
  };
  for (int k = 0; k < bounded.count(); ++k)
    if (const double depth = bounded.layers[k].depth;
        depth > 0 && depth < kThinnestFilm && is_smooth(k) && is_smooth(k + 1))
      return fmt::format(
          "ways there and back in a film of optical depth {:g} between smooth "
          "interfaces are skipped by the scalar kernel",
          depth);
  return std::nullopt;
}

// The largest value of p, as fixed point must hold it.
double largest_density(const Stack& stack, const Plan& plan) {
  double largest = 1 / kPi;
  for (const int k : plan.layers)
    largest = std::max(largest, lamella::largest_density(stack.layers[k].medium));
  return largest;
}

}  // namespace

std::optional<std::string> why_not_lane_medium(const Medium& medium, double depth) {
  return std::visit([&](const auto& m) { return why_not_medium(m, depth); }, medium);
}

std::optional<std::string> why_not_lanes(const Stack& stack, const Plan& plan) {
  if (plan.isa == Isa::scalar) return "the scalar kernel was asked for";
  if (plan.has_grids()) return "walks through density grids have no kernel on lanes";
  if (stack.grains()) return "explicit geometry is traced in double";
  if (plan.boundaries) {
    if (auto reason = why_not_boundaries(stack, plan)) return reason;
  } else if (plan.layers.empty()) {
    return "no layer has depth: there is nothing to walk through";
  }
  const std::size_t parts = lane_parts(stack, plan).size();
  const std::size_t most = plan.boundaries ? kMostBoundedLayers : kMostLaneLayers;
  if (parts > most)
    return fmt::format("lanes hold {} layers, the stack has {} (deep ones count thrice)", most,
                       parts);
  if (plan.max_order > 1000000000) return "orders above 1e9 are not counted on lanes";
  bool common_albedo = true;
  for (const int k : plan.layers) {
    const Layer& layer = stack.layers[k];
    const double depth = layer.depth();
    const char* which = plan.layers.size() > 1 ? " of a layer" : "";
    if (depth < 1e-30 || (depth > kDeepest && std::isfinite(depth)))
      return fmt::format("an optical depth of {:g}{} is more than float resolves", depth, which);
    if (auto reason = why_not_lane_medium(layer.medium, depth)) return reason;
    common_albedo = common_albedo && layer.albedo == stack.layers[plan.layers[0]].albedo;
  }
  if (plan.channels == 3 && common_albedo && plan.max_order > kMostTabulatedOrders)
    return fmt::format("colour is recombined from orders up to {} only", kMostTabulatedOrders);
  return std::nullopt;
}

namespace {

// How far the largest term of next-event estimation is beyond what fixed point takes, in bits.
int bits_beyond(const Stack& stack, const Plan& plan, double largest_inverse_mu) {
  const double largest = largest_density(stack, plan) * largest_inverse_mu;
  const double weight = plan.thinning.weight(plan.max_order);
  return std::max(0, static_cast<int>(std::ceil(std::log2(largest * weight / kPointLimit))));
}

double largest_inverse_mu(const CellGrid& grid) {
  return kLargestInverseMu * std::sqrt(grid.rows());
}

// Terms rounded to 2^-26 move f by less than 1e-6 still: a test holds it.
constexpr int kCoarsestWays = 8;
bool is_too_narrow(const Plan& plan, int bits) { return bits > (plan.thinning.is_on() ? 6 : 0); }

}  // namespace

int coarser_bits_along_ways(const Stack& stack, const Plan& plan) {
  return bits_beyond(stack, plan, largest_way(stack, plan));
}
int coarser_bits_at_points(const Stack& stack, const Plan& plan) {
  return bits_beyond(stack, plan, 1);
}
int coarser_bits_in_cells(const Stack& stack, const Plan& plan, const CellGrid& grid) {
  return bits_beyond(stack, plan, largest_inverse_mu(grid));
}

std::optional<std::string> why_not_lanes_at(const Stack& stack, const Plan& plan,
                                            const std::vector<Direction>& points) {
  if (auto reason = why_not_lanes(stack, plan)) return reason;
  if (points.empty()) return std::nullopt;
  if (plan.boundaries) {
    if (coarser_bits_along_ways(stack, plan) > kCoarsestWays)
      return "next-event estimation through interfaces: the phase function is too narrow for fixed "
             "point";
    for (const Direction wo : points)
      if (std::abs(wo.z) < kMostGrazingPoint || grazes_inside(stack, plan, wo))
        return "a point this close to grazing, outside or in a layer, asks for double";
    return std::nullopt;
  }
  if (is_too_narrow(plan, coarser_bits_at_points(stack, plan)))
    return "the phase function is too narrow for fixed point";
  for (const Direction wo : points)
    if (std::abs(wo.z) < kMostGrazingPoint) return "a point this close to grazing asks for double";
  return std::nullopt;
}

std::optional<std::string> why_not_lanes_in_cells(const Stack& stack, const Plan& plan,
                                                  const CellGrid& grid) {
  if (auto reason = why_not_lanes(stack, plan)) return reason;
  if (plan.boundaries) {
    if (coarser_bits_along_ways(stack, plan) > kCoarsestWays)
      return "next-event estimation through interfaces: the phase function is too narrow for fixed "
             "point";
    return std::nullopt;
  }
  if (is_too_narrow(plan, coarser_bits_in_cells(stack, plan, grid)))
    return "next-event estimation in cells: the phase function is too narrow for fixed point";
  return std::nullopt;
}

}  // namespace lamella
