#include "volume/lanes/lane_ways.h"

#include <algorithm>
#include <cmath>

#include "phase/math/direction.h"

namespace lamella {
namespace {

// Light that has met smooth interfaces alone is followed until this share of it is left.
constexpr double kFaintArrival = 1e-12;

// A direction at least kMostGrazingWay away from grazing, on the same side.
Direction off_grazing(Direction w) {
  if (std::abs(w.z) >= kMostGrazingWay) return w;
  const double z = std::copysign(kMostGrazingWay, w.z);
  const double scale = std::sqrt((1 - z * z) / (w.x * w.x + w.y * w.y));
  return {w.x * scale, w.y * scale, z};
}

}  // namespace

WayTables::WayTables(const Stack& stack, const Plan& plan, std::uint64_t seed, int batches)
    : stack_(stack, plan), seed_(seed), batches_(batches) {
  const std::vector<LanePart> parts = lane_parts(stack, plan);
  int layer = -1;
  double above = 0;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    // Parts of a deep layer follow each other.
    const bool goes_on = k > 0 && parts[k].layer >= 0 && parts[k].layer == parts[k - 1].layer;
    above = goes_on ? above + parts[k - 1].depth : 0;
    layer += goes_on ? 0 : 1;
    places_.layer[k] = layer;
    places_.above[k] = static_cast<float>(above);
    if (layer < stack_.count()) places_.depth[k] = static_cast<float>(stack_.layers[layer].depth);
  }
  places_.layer[parts.size()] = stack_.count();
  has_events_ = stack_.has_substrate || !plan.layers.empty();
}

WayTables::WayTables(const Stack& stack, const Plan& plan, Direction incident, std::uint64_t seed,
                     int batches, const std::vector<Direction>& points)
    : WayTables(stack, plan, seed, batches) {
  targets_ = static_cast<int>(points.size());
  for (const Direction& w : points) {
    x_.push_back(w.x);
    y_.push_back(w.y);
    z_.push_back(w.z);
  }
  find_arrivals(incident);
  ExitPaths paths(stack_);
  RandomStream stream(seed, 0, StreamPurpose::ways);
  for (int j = 0; j < targets_; ++j) paths.trace(points[j], j, stream);
  random_ = paths.is_random();
}

WayTables::WayTables(const Stack& stack, const Plan& plan, std::uint64_t seed, int batches,
                     const CellTargets& cells)
    : WayTables(stack, plan, seed, batches) {
  targets_ = cells.count();
  cells_ = &cells;
  random_ = true;
}

void WayTables::find_arrivals(Direction incident) {
  const int n = stack_.count();
  struct Ray {
    int boundary;
    Direction wi;
    double weight;
  };
  std::vector<Ray> rays{{incident.z > 0 ? 0 : n, incident, 1}};
  while (!rays.empty()) {
    const Ray ray = rays.back();
    rays.pop_back();
    const auto goes_on = [&](Direction wi, double weight) {
      const int layer = wi.z > 0 ? ray.boundary : ray.boundary - 1;
      if (layer < 0 || layer >= n) return;
      const WalkLayer& l = stack_.layers[layer];
      if (l.depth > 0) weight *= std::exp(-sigma(*l.medium, wi) * l.depth / std::abs(wi.z));
      if (weight > kFaintArrival) rays.push_back({wi.z > 0 ? layer + 1 : layer, wi, weight});
    };
    const auto& interface = stack_.boundaries[ray.boundary];
    if (!interface) {
      goes_on(ray.wi, ray.weight);
      continue;
    }
    if (!interface->is_smooth()) {
      arrivals_.push_back({ray.boundary, ray.wi, ray.weight});
      continue;
    }
    const Refraction<double> r = interface->smooth_refraction(ray.wi);
    goes_on({ray.wi.x, ray.wi.y, -ray.wi.z}, ray.weight * r.reflectance);
    if (r.cosine > 0)
      goes_on(-interface->smooth_refracted(ray.wi, r.cosine), ray.weight * (1 - r.reflectance));
  }
}

void WayTables::add_segments(const ExitPaths::Segments& s, bool at_substrate, double depth,
                             Set& set) const {
  struct Open {
    int first_target;
    std::size_t at;
  };
  std::vector<Open> open;  // the last block of every round: of the r-th segments to targets
  int target = -1;
  std::size_t round = 0;
  for (std::size_t j = 0; j < s.count(); ++j) {
    // To above, where the layer has no bottom.
    if (!at_substrate && !std::isfinite(depth) && s.z[j] < 0) continue;
    round = s.target[j] == target ? round + 1 : 0;
    target = s.target[j];
    const int first = target / LaneWayBlock::kCount * LaneWayBlock::kCount;
    if (round == open.size()) open.push_back({-1, 0});
    const bool is_new = open[round].first_target != first;
    if (is_new) {
      open[round] = {first, set.blocks.size()};
      set.blocks.push_back({});
      set.first_targets.push_back(first);
    }
    LaneWayBlock& to = set.blocks[open[round].at];
    const int k = target - first;
    const Direction given{s.x[j], s.y[j], s.z[j]};
    const Direction w = at_substrate ? given : off_grazing(given);
    if (is_new) {  // places without a way have a direction, too
      std::fill(std::begin(to.x), std::end(to.x), static_cast<float>(w.x));
      std::fill(std::begin(to.y), std::end(to.y), static_cast<float>(w.y));
      std::fill(std::begin(to.z), std::end(to.z), static_cast<float>(w.z));
    }
    to.x[k] = static_cast<float>(w.x);
    to.y[k] = static_cast<float>(w.y);
    to.z[k] = static_cast<float>(w.z);
    to.rate[k] = static_cast<float>(s.rate[j] * std::abs(given.z / w.z));
    to.sent[k] =
        static_cast<float>(at_substrate ? s.through[j] / kPi : s.through[j] / std::abs(w.z));
  }
}

// As BoundaryNextEvent::interface, for light that arrives with what is left of it on average.
void WayTables::add_zero(const ExitPaths& paths, Set& set) const {
  RandomStream none(0, 0, StreamPurpose::ways);  // single scattering takes no number
  for (const Arrival& at : arrivals_) {
    const Dielectric& interface = *stack_.boundaries[at.boundary];
    const auto send = [&](Direction w, double through, int target) {
      if (through > 0) set.zero[target] += at.weight * through * interface.eval(at.wi, w, none);
    };
    for (const bool up : {true, false}) {
      const int layer = up ? at.boundary - 1 : at.boundary;
      if (layer < 0 || layer >= stack_.count()) {
        for (int j = 0; j < targets_; ++j)
          if ((z_[j] > 0) == up) send({x_[j], y_[j], z_[j]}, 1, j);
        continue;
      }
      const ExitPaths::Segments& s = paths.in_layer(layer);
      const double depth = stack_.layers[layer].depth;
      for (std::size_t j = 0; j < s.count(); ++j)
        if ((s.z[j] > 0) == up)
          send({s.x[j], s.y[j], s.z[j]},
               s.through[j] * (s.rate[j] > 0 ? std::exp(-s.rate[j] * depth) : 1), s.target[j]);
    }
  }
}

WayTables::Set WayTables::set(int batch, std::uint64_t k) const {
  // Its numbers are those of its first walk.
  const std::uint64_t first =
      k * kWalksPerSet * static_cast<std::uint64_t>(batches_) + static_cast<std::uint64_t>(batch);
  Set set;
  if (!cells_) set.zero.resize(targets_);
  if (cells_ && !has_events_) return set;
  std::vector<double> x = x_, y = y_, z = z_;
  if (cells_) {
    std::vector<double> inverse_mu(targets_);
    for (auto* v : {&x, &y, &z}) v->resize(targets_);
    CellDirections(*cells_).redraw(seed_, first, x, y, z, inverse_mu);
  }
  RandomStream stream(seed_, first, StreamPurpose::ways);
  ExitPaths paths(stack_);
  for (int j = 0; j < targets_; ++j) paths.trace({x[j], y[j], z[j]}, j, stream);
  const int n = stack_.count();
  for (int layer = 0; layer <= n; ++layer) {
    const std::size_t from = set.blocks.size();
    if (layer == n)
      add_segments(paths.at_substrate(), true, 0, set);
    else if (stack_.layers[layer].depth > 0)
      add_segments(paths.in_layer(layer), false, stack_.layers[layer].depth, set);
    set.ways.count[layer] = static_cast<int>(set.blocks.size() - from);
  }
  const LaneWayBlock* block = set.blocks.data();
  const std::int32_t* first_target = set.first_targets.data();
  for (int layer = 0; layer <= n; ++layer) {
    set.ways.of[layer] = block;
    set.ways.first_target[layer] = first_target;
    block += set.ways.count[layer];
    first_target += set.ways.count[layer];
  }
  if (!cells_) add_zero(paths, set);
  return set;
}

double largest_way(const Stack& stack, const Plan& plan) {
  const BoundaryStack bounded(stack, plan);
  double least = 1, below = 1;
  for (const auto& boundary : bounded.boundaries)
    if (boundary) {
      least = std::min({least, boundary->above, boundary->below});
      below = boundary->below;
    }
  const double most = std::max(1.0, below);
  return most * most / (least * least) / kMostGrazingWay;
}

bool grazes_inside(const Stack& stack, const Plan& plan, Direction wo) {
  const BoundaryStack bounded(stack, plan);
  const double sine2 = wo.x * wo.x + wo.y * wo.y;
  const int n = bounded.count();
  // The index outside, on the side of w_o.
  double outside = 1;
  if (wo.z < 0 && bounded.boundaries[n]) outside = bounded.boundaries[n]->below;
  for (int k = 0; k <= n; ++k) {
    const auto& boundary = bounded.boundaries[k];
    if (!boundary) continue;
    for (const double index : {boundary->above, boundary->below}) {
      const double ratio = outside / index, cosine2 = 1 - sine2 * ratio * ratio;
      if (cosine2 >= 0 && cosine2 < kMostGrazingWay * kMostGrazingWay) return true;
    }
  }
  return false;
}

}  // namespace lamella
