#include "volume/lane_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "volume/lane_marginals.h"
#include "volume/walk.h"

namespace lamella {
namespace {

constexpr std::uint32_t kOrderCap = kTallyOrders;
constexpr double kDeepest = 1e4;         // optical depth at which float still resolves 1e-3
constexpr double kNarrowestSggx = 0.02;  // smallest diagonal entry of A, over the largest
constexpr double kNarrowestHg = 0.99;
constexpr double kMostGrazingPoint = 1e-4;
constexpr double kVertical = 1 - 1e-9;  // |z| of a vertical mean normal
constexpr double kDeepestFromBehind = 100;

template <class M>
constexpr bool is_vmf =
    std::is_same_v<M, MirrorFlakes<Vmf>> || std::is_same_v<M, LambertFlakes<Vmf>>;
template <class M>
constexpr bool is_sggx =
    std::is_same_v<M, MirrorFlakes<Sggx>> || std::is_same_v<M, LambertFlakes<Sggx>>;

std::optional<std::string> why_not_medium(const Medium& medium, double depth) {
  return std::visit(
      [&]<class M>(const M& m) -> std::optional<std::string> {
        if constexpr (is_vmf<M>) {
          if (m.is_delta() || vmf_concentration(m.ndf.alpha()) > kLargestMarginalKappa)
            return "vMF flakes narrower than alpha = 0.2 have no table";
          // Light that sees their backs meets null collisions almost only: as many as its way is
          // long.
          const double up = m.ndf.axis().z;
          if (std::abs(up) < kVertical || (up < 0 && depth > kDeepestFromBehind))
            return "tilted vMF flakes, or deep ones that face down, ask for too many null "
                   "collisions";
        } else if constexpr (is_sggx<M>) {
          const auto& a = m.ndf.matrix();
          const auto [least, most] = std::minmax({a.a00, a.a11, a.a22});
          if (least < kNarrowestSggx * most || most > 1e3 || least < 1e-3)
            return "SGGX flakes this narrow ask for double";
        } else if constexpr (std::is_same_v<M, HenyeyGreenstein>) {
          if (std::abs(m.g) > kNarrowestHg) return "so narrow a forward peak asks for double";
        }
        return std::nullopt;
      },
      medium);
}

SggxMatrix<double> inverse_of(const SggxMatrix<double>& a) {
  const Direction x = a.solve({1, 0, 0}), y = a.solve({0, 1, 0}), z = a.solve({0, 0, 1});
  return {x.x, x.y, y.y, x.z, y.z, z.z};
}

void copy(const SggxMatrix<double>& a, float* to) {
  const double numbers[] = {a.a00, a.a10, a.a11, a.a20, a.a21, a.a22};
  std::transform(std::begin(numbers), std::end(numbers), to,
                 [](double x) { return static_cast<float>(x); });
}

// The largest value of p, as fixed point must hold it.
double largest_density(const Medium& medium) {
  if (const auto* mirror = std::get_if<MirrorFlakes<Sggx>>(&medium)) {
    const SggxMatrix<double>& a = mirror->ndf.matrix();
    const SggxMatrix<double> b = inverse_of(a);
    // The norms bound |A u| above and below.
    const double norm = std::sqrt(a.a00 * a.a00 + a.a10 * a.a10 + a.a11 * a.a11 + a.a20 * a.a20 +
                                  a.a21 * a.a21 + a.a22 * a.a22);
    const double inverse_norm = std::sqrt(b.a00 * b.a00 + b.a10 * b.a10 + b.a11 * b.a11 +
                                          b.a20 * b.a20 + b.a21 * b.a21 + b.a22 * b.a22);
    return std::pow(norm, 4) / (4 * kPi * a.determinant()) * inverse_norm;
  }
  if (const auto* hg = std::get_if<HenyeyGreenstein>(&medium))
    return henyey_greenstein_phase(std::abs(hg->g), 1.0);
  return 1;
}

}  // namespace

std::optional<std::string> why_not_lanes(const Stack& stack, const Plan& plan) {
  if (plan.isa == Isa::scalar) return "the scalar kernel was asked for";
  if (plan.has_grids()) return "lanes have no kernel for density grids";
  if (stack.grains()) return "explicit geometry is traced in double";
  if (plan.layers.size() != 1) return "lanes have no kernel for several layers yet";
  if (stack.substrate) return "lanes have no kernel for a substrate yet";
  if (plan.channels != 1) return "lanes have no kernel for colour yet";
  const Layer& layer = stack.layers[plan.layers[0]];
  if (layer.f0 != Rgb(1)) return "lanes have no kernel for Schlick's factor yet";
  const double depth = layer.depth();
  if (depth < 1e-30 || (depth > kDeepest && std::isfinite(depth)))
    return fmt::format("an optical depth of {:g} is more than float resolves", depth);
  if (plan.max_order > 1000000000) return "orders above 1e9 are not counted on lanes";
  return why_not_medium(layer.medium, depth);
}

std::optional<std::string> why_not_lanes_at(const Stack& stack, const Plan& plan,
                                            const std::vector<Direction>& points) {
  if (auto reason = why_not_lanes(stack, plan)) return reason;
  const Medium& medium = stack.layers[plan.layers[0]].medium;
  if (points.empty()) return std::nullopt;
  if (std::holds_alternative<MirrorFlakes<Vmf>>(medium))
    return "lanes have no next-event estimation for vMF mirrors yet";
  if (largest_density(medium) > kPointLimit) return "the phase function is too narrow for float";
  for (const Direction wo : points)
    if (std::abs(wo.z) < kMostGrazingPoint) return "a point this close to grazing asks for double";
  return std::nullopt;
}

void LaneRun::set_up(const Stack& stack, const Plan& plan, Direction incident, std::uint64_t seed) {
  const Layer& layer = stack.layers[plan.layers[0]];
  walk_ = walk_lanes_for(plan.isa);
  incident_ = incident;
  albedo_ = layer.albedo.r;
  task_.depth = static_cast<float>(layer.depth());
  task_.wi[0] = static_cast<float>(incident.x);
  task_.wi[1] = static_cast<float>(incident.y);
  task_.wi[2] = static_cast<float>(incident.z);
  task_.from_above = incident.z > 0;
  task_.orders_per_absorption = albedo_ < 1 ? static_cast<float>(-1 / std::log(albedo_))
                                            : std::numeric_limits<float>::infinity();
  task_.black = albedo_ == 0;
  task_.max_order = static_cast<std::uint32_t>(plan.max_order);
  task_.seed = seed;
  task_.index_stride = static_cast<std::uint32_t>(counts_.size());
  task_.order_cap = kOrderCap;
  LaneMediumNumbers& numbers = task_.medium;
  double area = sigma(layer.medium, incident);
  std::visit(
      [&]<class M>(const M& m) {
        if constexpr (std::is_same_v<M, LambertSphere>) {
          numbers.kind = LaneMediumKind::lambert_sphere;
        } else if constexpr (std::is_same_v<M, HenyeyGreenstein>) {
          numbers.kind = LaneMediumKind::henyey_greenstein;
          numbers.g = static_cast<float>(m.g);
        } else if constexpr (is_sggx<M>) {
          numbers.kind = std::is_same_v<M, MirrorFlakes<Sggx>> ? LaneMediumKind::sggx_mirror
                                                               : LaneMediumKind::sggx_lambert;
          const SggxMatrix<double>& a = m.ndf.matrix();
          copy(a, numbers.a);
          copy(inverse_of(a), numbers.inverse);
          numbers.density_scale = static_cast<float>(1 / (4 * kPi * a.determinant()));
        } else {
          numbers.kind = std::is_same_v<M, MirrorFlakes<Vmf>> ? LaneMediumKind::vmf_mirror
                                                              : LaneMediumKind::vmf_lambert;
          const Direction axis = m.ndf.axis();
          numbers.axis[0] = static_cast<float>(axis.x);
          numbers.axis[1] = static_cast<float>(axis.y);
          numbers.axis[2] = static_cast<float>(axis.z);
          const double front = m.ndf.sigma(axis), back = m.ndf.sigma(-axis);
          const double side = m.ndf.sigma(frame_around(axis).s);
          numbers.front = static_cast<float>(front);
          numbers.back = static_cast<float>(back);
          numbers.side = static_cast<float>(side);
          // The first flight is by the majorant, as all others.
          const double u = dot(incident, axis);
          area = std::sqrt(std::max(0.0, (1 - u) * (1 + u))) * side +
                 std::abs(u) * (u < 0 ? back : front);
          marginals_ = vmf_marginals(vmf_concentration(m.ndf.alpha()));
          numbers.marginals = marginals_.data();
        }
      },
      layer.medium);
  task_.first_flight = static_cast<float>(std::abs(incident.z) / area);
  const double chance = -std::expm1(-layer.depth() * area / std::abs(incident.z));
  if (chance <= kForcedChance) {
    chance_ = chance;
    task_.forced_chance = static_cast<float>(chance);
  }
  for (Counts& c : counts_) c.ends.resize(kWalkEnds * (kOrderCap + 1));
}

LaneRun::LaneRun(const Stack& stack, const Plan& plan, Direction incident, std::uint64_t seed,
                 int batches, const CellTargets* cells)
    : counts_(batches) {
  set_up(stack, plan, incident, seed);
  if (!cells) return;
  cells_ = cells;
  const CellGrid& grid = cells->grid;
  task_.cells.on = true;
  task_.cells.folded = grid.folded;
  task_.cells.both_sides = cells->both_sides;
  task_.cells.rows = grid.rows();
  task_.cells.columns = grid.columns();
  task_.cells.phi_cells = grid.phi_cells;
  task_.cells.azimuth_turns = static_cast<float>(cells->incident_azimuth / (2 * kPi));
  for (Counts& c : counts_)
    c.cells.resize(static_cast<std::size_t>(kTallyOrders) * cells->count() + 1);
}

LaneRun::LaneRun(const Stack& stack, const Plan& plan, Direction incident, std::uint64_t seed,
                 int batches, const std::vector<Direction>& points)
    : counts_(batches) {
  set_up(stack, plan, incident, seed);
  if (points.empty()) return;
  const Medium& medium = stack.layers[plan.layers[0]].medium;
  constexpr std::size_t kWidest = 16;
  const std::size_t padded = (points.size() + kWidest - 1) / kWidest * kWidest;
  for (std::size_t j = 0; j < padded; ++j) {
    const Direction wo = points[std::min(j, points.size() - 1)];
    point_x_.push_back(static_cast<float>(wo.x));
    point_y_.push_back(static_cast<float>(wo.y));
    point_z_.push_back(static_cast<float>(wo.z));
    rate_.push_back(static_cast<float>(sigma(medium, -wo) / std::abs(wo.z)));
    if (j < points.size()) inverse_mu_.push_back(1 / std::abs(wo.z));
    task_.points.up += j < points.size() && wo.z > 0;
  }
  task_.points.count = static_cast<int>(points.size());
  task_.points.padded = static_cast<int>(padded);
  task_.points.x = point_x_.data();
  task_.points.y = point_y_.data();
  task_.points.z = point_z_.data();
  task_.points.rate = rate_.data();
  for (Counts& c : counts_) c.points.resize(kTallyOrders * padded);
}

void LaneRun::run(int batch, std::uint64_t from, std::uint64_t to, BatchTally& tally) {
  Counts& counts = counts_[batch];
  LaneWalkTask task = task_;
  std::uint64_t bad = 0;
  task.ends = counts.ends.data();
  task.cells.counts = counts.cells.data();
  task.points.sums = counts.points.data();
  task.lane_steps = &counts.lane_steps;
  task.busy_lane_steps = &counts.busy;
  task.bad_walk = &bad;
  const std::uint64_t stride = counts_.size();
  tally.walks += to - from;
  while (from < to) {
    // As far as the upper half of the index stays.
    const std::uint64_t index = from * stride + static_cast<std::uint64_t>(batch);
    const std::uint64_t low = index & 0xFFFFFFFFu;
    const std::uint64_t here = std::min(to - from, (0xFFFFFFFFu - low) / stride + 1);
    task.index_low = static_cast<std::uint32_t>(low);
    task.index_high = static_cast<std::uint32_t>(index >> 32);
    task.walks = static_cast<std::uint32_t>(here);
    walk_(task);
    if (bad) throw NonFiniteError(task.seed, bad - 1, incident_);
    from += here;
  }
  to_tally(counts, tally);
}

void LaneRun::to_tally(const Counts& counts, BatchTally& tally) const {
  const auto ended = [&](WalkEnd end, int order) {
    return static_cast<double>(counts.ends[static_cast<std::size_t>(end) * (kOrderCap + 1) +
                                           static_cast<std::size_t>(order)]);
  };
  // The weight after so many events; from the fourth on it stays.
  double weight[kTallyOrders + 1] = {chance_};
  for (int k = 1; k <= kTallyOrders; ++k)
    weight[k] = k < kTallyOrders ? albedo_ * weight[k - 1] : weight[k - 1];
  EnergySums energy{};
  const bool down = task_.from_above;
  energy.uncollided[0] = (1 - chance_) * static_cast<double>(tally.walks) +
                         chance_ * ended(down ? WalkEnd::down : WalkEnd::up, 0);
  energy.unresolved[0] = chance_ * ended(WalkEnd::unresolved, 0);
  for (int k = 1; k <= kTallyOrders; ++k) {
    energy.up[k - 1][0] = weight[k] * ended(WalkEnd::up, k);
    energy.down[k - 1][0] = weight[k] * ended(WalkEnd::down, k);
    energy.unresolved[0] += weight[k] * ended(WalkEnd::unresolved, k);
    // Absorbed: of each of the first three events a share, later walks as a whole.
    energy.absorbed[0] += weight[k] * ended(WalkEnd::absorbed, k);
    double events = 0;
    for (int end = 0; end < kWalkEnds; ++end)
      for (int order = k; order <= kTallyOrders; ++order)
        events += ended(static_cast<WalkEnd>(end), order);
    if (k < kTallyOrders) energy.absorbed[0] += events * (weight[k - 1] - weight[k]);
  }
  tally.energy = energy;
  tally.collisions = counts.busy;
  if (cells_) {
    const double scale = 1 / cells_->grid.projected_solid_angle();
    const std::size_t targets = cells_->count();
    for (std::size_t j = 0; j < tally.f.size(); ++j)
      tally.f[j] = scale * weight[1 + j / targets] * static_cast<double>(counts.cells[j]);
  }
  const std::size_t points = inverse_mu_.size(), padded = rate_.size();
  for (std::size_t slot = 0; points > 0 && slot < kTallyOrders; ++slot)
    for (std::size_t j = 0; j < points; ++j)
      tally.f[slot * points + j] = weight[slot] * albedo_ * inverse_mu_[j] / kPointUnits *
                                   static_cast<double>(counts.points[slot * padded + j]);
}

double LaneRun::occupancy() const {
  double steps = 0, busy = 0;
  for (const Counts& c : counts_) {
    steps += static_cast<double>(c.lane_steps);
    busy += static_cast<double>(c.busy);
  }
  return steps > 0 ? busy / steps : 0;
}

}  // namespace lamella
