#include "volume/lanes/lane_setting.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "phase/medium/vmf.h"
#include "volume/lanes/lane_marginals.h"
#include "volume/lanes/lane_normals.h"
#include "volume/lanes/lane_null_flakes.h"

namespace lamella {
namespace {

int words_of(LaneMediumKind kind) {
  switch (kind) {
    case LaneMediumKind::lambert_sphere:
      return LambertSphereOnLanes<double>::kWords;
    case LaneMediumKind::henyey_greenstein:
      return HenyeyGreensteinOnLanes<double>::kWords;
    case LaneMediumKind::rayleigh:
      return RayleighOnLanes<double>::kWords;
    case LaneMediumKind::sggx_mirror:
      return SggxMirrorOnLanes<double>::kWords;
    case LaneMediumKind::sggx_lambert:
      return SggxLambertOnLanes<double>::kWords;
    case LaneMediumKind::vmf_mirror:
      return VmfMirrorOnLanes<double>::kWords;
    case LaneMediumKind::vmf_lambert:
      return VmfLambertOnLanes<double>::kWords;
    case LaneMediumKind::substrate:
      return SubstrateOnLanes<double>::kWords;
  }
  return 0;
}

// Of flakes whose normals are taken by null collisions: alpha, |z| of the mean normal, and the
// depth where it points down, as light that sees backs only is refused in proportion to its path.
constexpr double kNarrowest = 0.01, kVertical = 1 - 1e-9, kDeepestFromBehind = 100;

bool are_upright(const Vmf& flakes, double depth) {
  const double up = flakes.axis().z;
  return flakes.alpha() >= kNarrowest &&
         (up > kVertical || (up < -kVertical && depth <= kDeepestFromBehind));
}

// A depth that light reaches where it meets nothing, see Vmf::sigma.
constexpr double kForGood = 1e28;

// The least -u for which sigma(u) is below what lanes take for nothing, with room for the error of
// its table; 2 where it never is.
double hidden_cosine(double alpha) {
  const double nothing = std::log(1e-30) - 0.01;
  if (log_vmf_sigma(-1, alpha) > nothing) return 2;
  double seen = 0, hidden = 1;
  for (int step = 0; step < 30; ++step) {
    const double middle = (seen + hidden) / 2;
    (log_vmf_sigma(-middle, alpha) > nothing ? seen : hidden) = middle;
  }
  return hidden;
}

template <class Scalar>
class LayerWriter {
 public:
  LayerWriter(LaneSetting<Scalar>& to, int layer, Direction incident)
      : to_(to), layer_(layer), incident_(incident) {}

  /// sigma(w_i), or the majorant that flights are by.
  double area = 1;
  /// Whether light of any direction meets something.
  bool sees_both_sides = true;

  void set(int field, double value) {
    to_.layers.value[field][layer_] = static_cast<Scalar>(value);
  }
  void set_kind(LaneMediumKind kind) {
    set(kKind, static_cast<int>(kind));
    to_.walk.kinds |= 1u << static_cast<int>(kind);
    to_.walk.words = std::max(to_.walk.words, words_of(kind));
  }
  void set_matrix(int field, const SggxMatrix<double>& a) {
    const double numbers[] = {a.a00, a.a10, a.a11, a.a20, a.a21, a.a22};
    for (int k = 0; k < 6; ++k) set(field + k, numbers[k]);
  }

  void set_unit_matrix() { set_matrix(kA, {1, 0, 1, 0, 0, 1}); }

  // Media without a kernel never get here: why_not_lanes (lane_limits.cpp) refuses them.
  template <class M>
  void operator()(const M&) {
    throw std::logic_error("lanes have no kernel for this medium");
  }
  void operator()(const LambertSphere&) { particle(LaneMediumKind::lambert_sphere); }
  void operator()(const HenyeyGreenstein& m) {
    particle(LaneMediumKind::henyey_greenstein);
    set(kG, m.g);
  }
  void operator()(const Rayleigh&) { particle(LaneMediumKind::rayleigh); }
  void operator()(const MirrorFlakes<Sggx>& m) { sggx(LaneMediumKind::sggx_mirror, m.ndf); }
  void operator()(const LambertFlakes<Sggx>& m) { sggx(LaneMediumKind::sggx_lambert, m.ndf); }
  void operator()(const MirrorFlakes<Vmf>& m) { vmf(LaneMediumKind::vmf_mirror, m.ndf); }
  void operator()(const LambertFlakes<Vmf>& m) { vmf(LaneMediumKind::vmf_lambert, m.ndf); }

 private:
  void particle(LaneMediumKind kind) {
    set_kind(kind);
    set_unit_matrix();
  }
  void sggx(LaneMediumKind kind, const Sggx& flakes) {
    set_kind(kind);
    const SggxMatrix<double>& a = flakes.matrix();
    set_matrix(kA, a);
    set_matrix(kInverse, a.inverse());
    set(kDensityScale, 1 / (4 * kPi * a.determinant()));
    area = flakes.sigma(incident_);
  }
  void null_vmf(const Vmf& flakes) {
    const Direction axis = flakes.axis();
    set(kAxis + 2, axis.z > 0 ? 1 : -1);
    const VisibleNormalMixture<double> mixture{flakes.sigma(axis), flakes.sigma(-axis),
                                               flakes.sigma(frame_around(axis).s)};
    set(kFront, mixture.front);
    set(kBack, mixture.back);
    set(kSide, mixture.side);
    const std::vector<float> marginals = vmf_marginals(vmf_concentration(flakes.alpha()));
    set(kTable, 0);
    to_.tables.resize(marginals.size() * sizeof(float) / sizeof(NormalPatch));
    std::memcpy(to_.tables.front().power, marginals.data(),
                to_.tables.size() * sizeof(NormalPatch));
    const double u = dot(incident_, axis);
    area = mixture.majorant(u, std::sqrt(std::max(0.0, (1 - u) * (1 + u))));
  }
  void vmf(LaneMediumKind kind, const Vmf& flakes) {
    set_kind(kind);
    if (to_.walk.null_collisions) return null_vmf(flakes);
    const Direction axis = flakes.axis(), across = frame_around(axis).s;
    const double numbers[] = {axis.x, axis.y, axis.z, across.x, across.y, across.z};
    for (int k = 0; k < 6; ++k) set(kAxis + k, numbers[k]);
    const double kappa = vmf_concentration(flakes.alpha());
    set(kKappa, kappa);
    set(kDensityScale, vmf_density(kappa, 1) / 4);
    set(kMean, vmf_mean_cosine(kappa));
    const double width = 1 / std::sqrt(kappa + 1);
    set(kWidth, width);
    set(kReach, 1 / std::min(1.0, kLargestBehind * width));
    const double facing = facing_cosine(kappa);
    set(kFacing, facing);
    set(kHidden, facing > 1 ? 2 : hidden_cosine(flakes.alpha()));
    const TiltSeries<double> tilt = tilt_series(kappa);
    set(kTilt, tilt.first);
    set(kTilt + 1, tilt.second);
    set(kTilt + 2, tilt.third);
    to_.walk.narrow = to_.walk.narrow || facing < 1;
    auto& tables = to_.tables;
    if (tables.empty()) tables = side_sheets();
    set(kTable, static_cast<double>(tables.size()));
    for (const auto& more : {back_sigma_pieces(kappa, flakes.alpha()), vmf_normal_sheets(kappa)})
      tables.insert(tables.end(), more.begin(), more.end());
    area = flakes.sigma(incident_);
    sees_both_sides = false;
  }

  LaneSetting<Scalar>& to_;
  int layer_;
  Direction incident_;
};

template <class Scalar>
bool is_upright(const LayerNumbers<Scalar>& layers, int count) {
  const auto& a = layers.value;
  for (int k = 0; k < count; ++k)
    if (a[kA + 1][k] != 0 || a[kA + 3][k] != 0 || a[kA + 4][k] != 0 || a[kA][k] != a[kA + 2][k])
      return false;
  return true;
}

template <class Scalar>
void write_boundary(const std::optional<Dielectric>& interface, int at,
                    BoundaryNumbers<Scalar>& to) {
  if (!interface) return;
  const auto set = [&](int field, double value) {
    to.value[field][at] = static_cast<Scalar>(value);
  };
  set(kShape, 1 + static_cast<int>(interface->facets.shape));
  const double down = interface->below / interface->above;
  set(kRatioDown, down);
  set(kExcessDown, (down - 1) * (down + 1));
  set(kRatioUp, 1 / down);
  set(kExcessUp, (1 - down) * (1 + down) / (down * down));
  if (interface->is_smooth()) {
    to.smooth = true;
    return;
  }
  to.rough = true;
  const bool ggx = interface->facets.shape == FacetShape::ggx;
  to.ggx = to.ggx || ggx;
  to.beckmann = to.beckmann || !ggx;
  to.words = std::max(to.words, ggx ? kGgxWords : kBeckmannWords);
  set(kAlphaX, interface->facets.alpha_x);
  set(kAlphaY, interface->facets.alpha_y);
  set(kMasking, static_cast<int>(interface->masking));
  to.beta = to.beta || interface->masking == Masking::beta;
  to.separable = to.separable || interface->masking == Masking::separable;
}

}  // namespace

std::vector<LanePart> lane_parts(const Stack& stack, const Plan& plan) {
  std::vector<LanePart> parts;
  const auto add = [&](int layer, double depth, const std::optional<Dielectric>& above) {
    if (depth > kDeepestPart && std::isfinite(depth)) {
      parts.push_back({layer, kDeepestPart / 2, above});
      parts.push_back({layer, depth - kDeepestPart});
      parts.push_back({layer, kDeepestPart / 2});
    } else {
      parts.push_back({layer, depth, above});
    }
  };
  if (plan.boundaries) {
    const BoundaryStack bounded(stack, plan);
    for (int k = 0; k < bounded.count(); ++k)
      add(bounded.sources[k], bounded.layers[k].depth, bounded.boundaries[k]);
    if (parts.empty()) parts.push_back({-1, 0, bounded.boundaries[0]});  // an interface alone
  } else {
    for (const int k : plan.layers) add(k, stack.layers[k].depth(), {});
  }
  return parts;
}

std::optional<Dielectric> lane_bottom(const Stack& stack, const Plan& plan) {
  if (!plan.boundaries) return std::nullopt;
  const BoundaryStack bounded(stack, plan);
  return bounded.count() > 0 ? bounded.boundaries.back() : std::nullopt;
}

bool takes_null_collisions(const Stack& stack, const Plan& plan) {
  if (plan.boundaries || stack.substrate || lane_parts(stack, plan).size() != 1) return false;
  const Layer& layer = stack.layers[plan.layers[0]];
  if (layer.f0 != Rgb(1)) return false;  // walks carry weights
  if (const auto* mirrors = std::get_if<MirrorFlakes<Vmf>>(&layer.medium))
    return are_upright(mirrors->ndf, layer.depth());
  const auto* lambertians = std::get_if<LambertFlakes<Vmf>>(&layer.medium);
  return lambertians != nullptr && are_upright(lambertians->ndf, layer.depth());
}

template <class Scalar>
bool walks_by_layer(const WalkSetting<Scalar>& walk) {
  const unsigned substrate = 1u << static_cast<int>(LaneMediumKind::substrate);
  const unsigned vmf = 1u << static_cast<int>(LaneMediumKind::vmf_mirror) |
                       1u << static_cast<int>(LaneMediumKind::vmf_lambert);
  const unsigned media = walk.kinds & ~substrate;
  const bool mixed = std::popcount(media) > 1;
  if (mixed && (media & vmf) != 0) return true;
  // With more layers each has fewer walks, and its turns are shorter.
  constexpr int kMostLayers = 4;
  constexpr double kDeep = 8;
  if (walk.layer_count < 2 || walk.layer_count > kMostLayers) return false;
  double depth = 0;
  for (int k = 0; k < walk.layer_count; ++k)
    depth += std::min<double>(walk.layers->value[kDepth][k], kDeep);
  return depth >= (mixed ? 0.5 : 1) * walk.layer_count;
}
template bool walks_by_layer(const WalkSetting<float>&);
template bool walks_by_layer(const WalkSetting<double>&);

template <class Scalar>
LaneSetting<Scalar>::LaneSetting(const Stack& stack, const Plan& plan, Direction incident,
                                 std::uint64_t seed, bool counted)
    : parts(lane_parts(stack, plan)) {
  const auto channels = [](Rgb c) { return std::array<double, 3>{c.r, c.g, c.b}; };
  walk.layers = &layers;
  walk.layer_count = static_cast<int>(parts.size());
  walk.null_collisions = counted && takes_null_collisions(stack, plan);
  walk.grey = plan.channels == 1;
  walk.substrate = stack.substrate.has_value();
  walk.from_above = incident.z > 0;
  // The limit of grazing light, which float would round to a horizontal way.
  const double wi[] = {incident.x, incident.y,
                       std::copysign(std::max(std::abs(incident.z), 1e-30), incident.z)};
  std::copy(std::begin(wi), std::end(wi), walk.wi);
  walk.max_order = static_cast<std::uint32_t>(plan.max_order);
  walk.thinned_from = plan.thinning.first;
  walk.seed = seed;
  const auto below = channels(stack.substrate ? stack.substrate->albedo : Rgb(0));
  const bool empty = plan.layers.empty();  // the substrate's events are all there are
  albedo = empty ? below : channels(stack.layers[plan.layers[0]].albedo);
  common_albedo = empty || !walk.substrate;
  double tau = 0;
  for (int k = 0; k < walk.layer_count; ++k) {
    LayerWriter<Scalar> writer(*this, k, incident);
    writer.set(kDepth, parts[k].depth);
    if (parts[k].layer < 0) {
      writer.set_unit_matrix();
      continue;
    }
    const Layer& layer = stack.layers[parts[k].layer];
    std::visit(writer, layer.medium);
    // Light that no flake of a half space faces leaves it for good.
    if (std::isinf(parts[k].depth) && !writer.sees_both_sides) writer.set(kDepth, kForGood);
    tau += parts[k].depth * writer.area / std::abs(incident.z);
    for (int c = 0; c < 3; ++c) {
      writer.set(kAlbedo + c, layer.albedo[c]);
      writer.set(kF0 + c, layer.f0[c]);
    }
    const bool fresnel = layer.f0 != Rgb(1);
    walk.fresnel = walk.fresnel || fresnel;
    common_albedo = common_albedo && !fresnel && channels(layer.albedo) == albedo;
  }
  if (!tables.empty()) layers.tables = tables.front().power[0];
  walk.upright = is_upright(layers, walk.layer_count);
  if (walk.substrate) {
    walk.kinds |= 1u << static_cast<int>(LaneMediumKind::substrate);
    walk.words = std::max(walk.words, words_of(LaneMediumKind::substrate));
    std::copy(below.begin(), below.end(), walk.substrate_albedo);
  }
  walk.by_layer = plan.layer_turns == LayerTurns::always ||
                  (plan.layer_turns == LayerTurns::where_faster && walks_by_layer(walk));
  const double brightest = *std::max_element(albedo.begin(), albedo.end());
  walk.orders_per_absorption = brightest < 1 ? static_cast<Scalar>(-1 / std::log(brightest))
                                             : std::numeric_limits<Scalar>::infinity();
  walk.black = brightest == 0;
  walk.ends_absorb =
      common_albedo && !walk.black && !plan.thinning.is_on() &&
      kLargestExponential * static_cast<double>(walk.orders_per_absorption) + kRouletteOrder + 1 <
          static_cast<double>(plan.max_order);
  if (plan.boundaries) {
    for (int k = 0; k < walk.layer_count; ++k) write_boundary(parts[k].above, k, boundaries);
    write_boundary(lane_bottom(stack, plan), walk.layer_count, boundaries);
    // One number less where masking takes a uniform one.
    if (boundaries.ggx && !boundaries.beckmann && !boundaries.beta)
      boundaries.words = kGgxWords - 1;
    int interfaces = 0;
    for (int k = 0; k <= walk.layer_count; ++k)
      if (boundaries.value[kShape][k] > 0) boundaries.only = interfaces++ == 0 ? k : -1;
    walk.boundaries = &boundaries;
    walk.collides_at_once = boundaries.value[kShape][walk.from_above ? 0 : walk.layer_count] > 0;
    return;
  }
  collides = -std::expm1(-tau);
  constexpr double kAtOnce = 0.999;
  walk.collides_at_once = collides > kAtOnce;
  if (collides <= kForcedChance && !walk.substrate) {
    chance = collides;
    walk.forced_chance = static_cast<Scalar>(collides);
  }
}

template <class Scalar>
void LaneSetting<Scalar>::force_flights() {
  walk.forced_flights = kForcedFlights;
  walk.by_layer = false;
  walk.collides_at_once = true;
  chance = collides;
  walk.forced_chance = static_cast<Scalar>(collides);
  walk.forced_rest = static_cast<Scalar>(1 - collides);
}

template <class Scalar>
double LaneSetting<Scalar>::weight_after(int channel, std::uint32_t order) const {
  const double c = albedo[channel];
  const double brightest = *std::max_element(albedo.begin(), albedo.end());
  const double early = std::min(order, kRouletteOrder - 1);
  if (order < kRouletteOrder || c == brightest) return std::pow(c, early);
  return c == 0 ? 0 : std::pow(c, early) * std::pow(c / brightest, order - early);
}

template struct LaneSetting<float>;
template struct LaneSetting<double>;

}  // namespace lamella
