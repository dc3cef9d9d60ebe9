#include "volume/grains/grain_walk.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "phase/math/sampling.h"
#include "phase/surface/fresnel.h"
#include "volume/grains/traced_geometry.h"
#include "volume/walk/departures.h"
#include "volume/walk/path_weight.h"
#include "volume/walk/walk.h"

namespace lamella {
namespace {

// Words of a lattice's step: the place in the tile, then the events' numbers.
constexpr int kEventWord = 1;

Direction turned(Direction w, double cosine, double sine) {
  return {cosine * w.x - sine * w.y, sine * w.x + cosine * w.y, w.z};
}

/// Light at a surface: what it reflects by Lambert's law, seen from outside.
struct DiffuseEvent {
  Direction point, normal;
  double ior = 1;       ///< above 1: seen through a dielectric's surface
  double entering = 1;  ///< 1 minus the mean Fresnel reflectance of that

  /// Density of leaving along wo [1/sr].
  [[nodiscard]] double density(Direction wo) const {
    const double cosine = dot(normal, wo);
    if (cosine <= 0) return 0;
    const double passes = ior > 1 ? (1 - fresnel_reflectance(cosine, ior)) / entering : 1;
    return passes * cosine / kPi;
  }
  [[nodiscard]] Direction sample(RandomStream& stream) const {
    for (;;) {
      const double u1 = stream.uniform(), u2 = stream.uniform();
      const Direction wo = cosine_hemisphere(normal, u1, u2);
      if (ior == 1) return wo;
      // Most passes at the normal.
      const double most = 1 - fresnel_reflectance(1, ior);
      const double cosine = std::clamp(dot(normal, wo), 0.0, 1.0);
      if (stream.uniform() * most < 1 - fresnel_reflectance(cosine, ior)) return wo;
    }
  }
};

/// One batch's walks.
template <int C>
class Walker {
 public:
  using Weights = std::array<double, C>;

  Walker(const GrainSetting& setting, GrainScores scores, const CellTargets& targets,
         const std::vector<Direction>& points, BatchTally& tally)
      : setting_(setting), scores_(scores), targets_(targets), tally_(tally), directions_(points) {
    if (scores == GrainScores::next_event) directions_.resize(targets.count());
  }

  void enter_realisation(std::uint64_t number) {
    if (scene_ && number == realisation_) return;
    leave_realisation();
    realisation_ = number;
    scene_ = std::make_unique<TracedGeometry>(setting_.geometry, setting_.seed, number);
    RandomStream stream(setting_.seed, number, StreamPurpose::measure);
    const double angle = 2 * kPi * stream.uniform();
    cosine_ = std::cos(angle);
    sine_ = std::sin(angle);
  }

  void leave_realisation() {
    if (scene_) tally_.holes += scene_->holes();
    scene_.reset();
  }

  void walk(std::uint64_t index);

  /// From here on what leaves is kept.
  void keep(WalkSamples& samples) { kept_.emplace(setting_.incident, samples); }

 private:
  [[nodiscard]] bool survives(const Weights& kept, RandomStream& stream) {
    return weight_.survives(kept, order_, tally_.energy, stream);
  }
  void begin_targets(std::uint64_t index, WalkLattice::Point lattice);
  /// Next-event estimation: sent(wo) is f cos / |mu_o| per channel of what leaves `point` along wo.
  template <class Sent>
  void score(Direction point, const Sent& sent);
  void score(const DiffuseEvent& event, const Weights& kept);
  void leave(Direction wo, bool after_mirror);
  /// The event at the substrate; false if the walk ends there.
  [[nodiscard]] bool reflect(const GrainHit& hit, RandomStream& stream);
  /// The event at a grain; false if the walk ends there.
  [[nodiscard]] bool scatter(const GrainHit& hit, RandomStream& stream);

  const GrainSetting& setting_;
  GrainScores scores_;
  const CellTargets& targets_;
  BatchTally& tally_;
  std::vector<Direction> directions_;
  std::optional<DepartureScorer> kept_;
  std::unique_ptr<TracedGeometry> scene_;
  std::uint64_t realisation_ = 0;
  double cosine_ = 1, sine_ = 0;

  // Of the walk under way.
  PathWeight<C> weight_;
  Direction wi_{};  // as the tile sees it
  std::uint64_t order_ = 0;
  bool after_mirror_ = false;
  double checksum_ = 0;
};

template <int C>
void Walker<C>::begin_targets(std::uint64_t index, WalkLattice::Point lattice) {
  if (scores_ != GrainScores::next_event) return;
  // The same place within every cell, as in the walk through layers.
  RandomStream stream(setting_.seed, index, StreamPurpose::targets);
  if (lattice.has(0))
    stream.put(lattice.word(0, kLatticeTargetWord), lattice.word(0, kLatticeTargetWord + 1));
  const double u_mu = stream.uniform(), u_phi = stream.uniform();
  const CellGrid& grid = targets_.grid;
  for (int k = 0; k < targets_.count(); ++k) {
    const bool up = k < grid.cells();
    const int cell = up ? k : k - grid.cells();
    const int row = cell / grid.columns(), column = cell % grid.columns();
    const double mu = std::sqrt((grid.mu_cells - row - u_mu) / grid.mu_cells);
    const double phi = targets_.incident_azimuth + 2 * kPi * (column + u_phi) / grid.phi_cells;
    directions_[k] = direction_from_mu_phi(up ? mu : -mu, phi);
  }
}

template <int C>
template <class Sent>
void Walker<C>::score(Direction point, const Sent& sent) {
  if (scores_ != GrainScores::next_event && scores_ != GrainScores::points) return;
  const std::size_t count = directions_.size();
  double* sums = tally_.f.data() + order_slot(order_) * C * count;
  for (std::size_t k = 0; k < count; ++k) {
    const Direction wo = turned(directions_[k], cosine_, sine_);
    if (wo.z < 0 && setting_.has_substrate) continue;
    const Weights f = sent(wo);
    const double largest = *std::max_element(f.begin(), f.end());
    if (largest <= 0 || !scene_->is_free(point, wo)) continue;
    checksum_ += largest;
    for (int c = 0; c < C; ++c) sums[c * count + k] += weight_.value[c] * f[c];
  }
}

template <int C>
void Walker<C>::score(const DiffuseEvent& event, const Weights& kept) {
  score(event.point, [&](Direction wo) {
    const double transport = event.density(wo) / std::abs(wo.z);
    Weights f;
    for (int c = 0; c < C; ++c) f[c] = kept[c] * transport;
    return f;
  });
}

template <int C>
void Walker<C>::leave(Direction wo, bool after_mirror) {
  // Next-event estimation has counted all light but what a mirror sent out.
  if (scores_ == GrainScores::analog || (scores_ == GrainScores::next_event && after_mirror))
    AnalogScorer<C>(targets_, tally_).leave(wo, weight_.value, order_, after_mirror);
}

template <int C>
bool Walker<C>::scatter(const GrainHit& hit, RandomStream& stream) {
  const GrainSurface surface = setting_.geometry.surface;
  const double cosine = std::clamp(dot(wi_, hit.normal), 0.0, 1.0);
  Weights kept;
  after_mirror_ = false;
  DiffuseEvent event{hit.point, hit.normal};
  if (surface == GrainSurface::mirror || surface == GrainSurface::conductor) {
    const double grazing = schlick_weight(cosine);
    for (int c = 0; c < C; ++c)
      kept[c] = setting_.albedo[c] * (setting_.f0[c] + (1 - setting_.f0[c]) * grazing);
    after_mirror_ = true;
  } else if (surface == GrainSurface::dielectric) {
    event.ior = setting_.geometry.ior;
    event.entering = setting_.entering;
    const double reflected = fresnel_reflectance(cosine, event.ior);
    for (int c = 0; c < C; ++c) kept[c] = (1 - reflected) * setting_.inner[c];
    score(event, kept);
    after_mirror_ = stream.uniform() < reflected;
    for (int c = 0; c < C; ++c) kept[c] = after_mirror_ ? 1 : setting_.inner[c];
  } else {
    for (int c = 0; c < C; ++c) kept[c] = setting_.albedo[c];
    score(event, kept);
  }
  if (!survives(kept, stream)) return false;
  wi_ = -(after_mirror_ ? mirrored(wi_, hit.normal) : event.sample(stream));
  return true;
}

template <int C>
bool Walker<C>::reflect(const GrainHit& hit, RandomStream& stream) {
  Weights kept;
  after_mirror_ = false;
  if (!setting_.substrate_law) {
    for (int c = 0; c < C; ++c) kept[c] = setting_.substrate_albedo[c];
    const DiffuseEvent event{hit.point, hit.normal};
    score(event, kept);
    if (!survives(kept, stream)) return false;
    wi_ = -event.sample(stream);
    return true;
  }
  score(hit.point, [&](Direction wo) {
    const Rgb value = setting_.substrate_law->eval(wi_, wo, stream);
    Weights f;
    for (int c = 0; c < C; ++c) f[c] = value[c];
    return f;
  });
  const auto sample = setting_.substrate_law->sample(wi_, stream);
  for (int c = 0; c < C; ++c) kept[c] = sample ? sample->weight[c] : 0;
  if (!survives(kept, stream) || !sample) return false;
  wi_ = -sample->wo;
  return true;
}

template <int C>
void Walker<C>::walk(std::uint64_t index) {
  RandomStream stream(setting_.seed, index, StreamPurpose::walk);
  const WalkLattice::Point lattice =
      setting_.lattice ? setting_.lattice->point(index) : WalkLattice::Point();
  begin_targets(index, lattice);
  lattice.put(0, kEventWord, stream);
  EnergySums& energy = tally_.energy;
  weight_ = {};
  order_ = 0;
  after_mirror_ = false;
  checksum_ = 0;
  wi_ = turned(setting_.incident, cosine_, sine_);
  Direction point{setting_.geometry.tile * stream.uniform(),
                  setting_.geometry.tile * stream.uniform(),
                  wi_.z > 0 ? setting_.geometry.top() : setting_.geometry.bottom()};
  for (;;) {
    const GrainHit hit = scene_->trace(point, -wi_);
    if (hit.end == RayEnd::lost) {
      weight_.add_to(energy.unresolved);
      break;
    }
    if (hit.end == RayEnd::up || (hit.end == RayEnd::down && !setting_.has_substrate)) {
      weight_.leave(energy, hit.end == RayEnd::down, order_, false);
      if (kept_) kept_->departs(turned(-wi_, cosine_, -sine_), weight_.value, order_, order_ == 0);
      if (order_ > 0) leave(turned(-wi_, cosine_, -sine_), after_mirror_);
      break;
    }
    if (order_ == setting_.max_order) {
      weight_.add_to(energy.unresolved);
      break;
    }
    ++order_;
    lattice.put(order_, kEventWord, stream);
    if (hit.end == RayEnd::down) {
      if (!reflect(hit, stream)) break;
    } else {
      ++tally_.collisions;
      if (!scatter(hit, stream)) break;
    }
    point = hit.point;
  }
  ++tally_.walks;
  double check = wi_.x + wi_.y + wi_.z + point.x + point.y + point.z + checksum_;
  for (int c = 0; c < C; ++c) check += weight_.value[c];
  if (!std::isfinite(check)) throw NonFiniteError(setting_.seed, index, setting_.incident);
}

}  // namespace

GrainSetting::GrainSetting(const Stack& stack, Direction incident_, std::uint64_t seed_,
                           std::uint64_t max_order_)
    : geometry(stack.grains()->in_units()),
      albedo(stack.layers[0].albedo),
      f0(stack.layers[0].f0),
      has_substrate(stack.substrate.has_value()),
      substrate_albedo(stack.substrate ? stack.substrate->albedo : Rgb(0)),
      substrate_law(stack.substrate ? stack.substrate->law : nullptr),
      incident(incident_),
      seed(seed_),
      max_order(max_order_) {
  if (stack.substrate && !stack.substrate->model.empty() && !substrate_law)
    throw std::logic_error(
        "the substrate's model has no law: see compare/request/substrate_model.h");
  if (geometry.surface == GrainSurface::dielectric) {
    entering = 1 - mean_fresnel_reflectance(geometry.ior);
    // Light that comes from inside finds the surface 1 - entering / ior^2 reflecting.
    const double back = 1 - entering / (geometry.ior * geometry.ior);
    for (int c = 0; c < 3; ++c) inner[c] = albedo[c] * (1 - back) / (1 - albedo[c] * back);
  }
  std::uint64_t walks = 64;
  while (walks < 8192 && 16 * static_cast<double>(walks) < geometry.expected_count()) walks *= 2;
  walks_per_realisation = walks;
}

template <int C>
void walk_among_grains(const GrainSetting& setting, GrainScores scores, const CellTargets& targets,
                       const std::vector<Direction>& points, int batch, int batches,
                       std::uint64_t from, std::uint64_t to, BatchTally& tally) {
  Walker<C> walker(setting, scores, targets, points, tally);
  for (std::uint64_t i = from; i < to; ++i) {
    walker.enter_realisation(i / setting.walks_per_realisation * batches + batch);
    walker.walk(i * batches + batch);
  }
  walker.leave_realisation();
}

template <int C>
WalkSamples samples_among_grains(const GrainSetting& setting, int batch, int batches,
                                 std::uint64_t from, std::uint64_t to) {
  WalkSamples samples;
  samples.channels = C;
  samples.walks = to - from;
  BatchTally spare;
  const CellTargets none;
  const std::vector<Direction> no_points;
  Walker<C> walker(setting, GrainScores::nothing, none, no_points, spare);
  walker.keep(samples);
  for (std::uint64_t i = from; i < to; ++i) {
    walker.enter_realisation(i / setting.walks_per_realisation * batches + batch);
    walker.walk(i * batches + batch);
  }
  walker.leave_realisation();
  return samples;
}

template WalkSamples samples_among_grains<1>(const GrainSetting&, int, int, std::uint64_t,
                                             std::uint64_t);
template WalkSamples samples_among_grains<3>(const GrainSetting&, int, int, std::uint64_t,
                                             std::uint64_t);
template void walk_among_grains<1>(const GrainSetting&, GrainScores, const CellTargets&,
                                   const std::vector<Direction>&, int, int, std::uint64_t,
                                   std::uint64_t, BatchTally&);
template void walk_among_grains<3>(const GrainSetting&, GrainScores, const CellTargets&,
                                   const std::vector<Direction>&, int, int, std::uint64_t,
                                   std::uint64_t, BatchTally&);

}  // namespace lamella
