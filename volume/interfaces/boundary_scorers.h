#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "volume/interfaces/exit_paths.h"
#include "volume/walk/scorers.h"

namespace lamella {

/// What walks through boundaries score with where nothing is aimed: cells count what leaves.
template <class Base>
struct UnaimedAtBoundaries : Base {
  using Base::Base;
  using Base::substrate;
  [[nodiscard]] static bool sees_mirrors() { return false; }
  template <std::size_t C>
  void substrate(const std::array<double, C>&, const SurfaceLaw&, Direction, std::uint64_t,
                 RandomStream&) {}
  template <std::size_t C>
  [[nodiscard]] bool interface(int, const Dielectric&, Direction, const std::array<double, C>&,
                               std::uint64_t, RandomStream&) {
    return false;
  }
};

/// Next-event estimation through interfaces: every event sends its share along the ways out
/// (ExitPaths). On cells, light that met nothing but interfaces and deltas counts in the cell where
/// it leaves; at points the first rough boundary that it meets is aimed, and ways meet mirrors as
/// substrates, each time as one more order. Ways cost as much as many
/// events: kWalksPerWay walks of a batch share them.
inline constexpr std::uint64_t kWalksPerWay = 8;

/// The part of the light along each target that next-event estimation counts where the walk's own
/// departures count the rest: `aimed` is the density [1/sr] with which the target was drawn. The
/// shares depend on the path alone, by the density of the direction that it takes at the event
/// that is scored; those of both ways are 1 together.
struct AimedShare {
  /// What stands for the density of walks beside that of one event's direction: most light is found
  /// after several of them.
  static constexpr double kWalks = 2;
  double aimed = std::numeric_limits<double>::infinity();  ///< all light is counted where it is

  /// Of departures, for the event's density.
  [[nodiscard]] static double walked(double density) { return kWalks + density; }
  /// Of what is aimed; density(): as above, asked for where the share is no 1.
  template <class Density>
  [[nodiscard]] double of(const Density& density) const {
    return aimed < std::numeric_limits<double>::infinity() ? 1 / (1 + walked(density()) / aimed)
                                                           : 1;
  }
};

template <int C>
class BoundaryNextEvent {
 public:
  BoundaryNextEvent(const BoundaryStack& stack, const CellTargets& cells, BatchTally& tally);
  /// Values at given directions, mu != 0; those that go up first. `share`: of all of them.
  BoundaryNextEvent(const BoundaryStack& stack, const std::vector<Direction>& points,
                    BatchTally& tally, AimedShare share = {});

  void begin_walk(std::uint64_t seed, std::uint64_t index);

  template <class Event>
  void collision(const WalkLayer& l, int layer, double y, const Event& event,
                 const std::array<double, C>& weight, std::uint64_t order) {
    const ExitPaths::Segments& s = ways().in_layer(layer);
    double* sums = sums_of(order);
    double checksum = 0;
    const auto& lobe = lobe_of(event);
    const bool mirrored = !s.mirrors.empty();
    for (std::size_t j = 0; j < s.count(); ++j) {
      if (mirrored) {
        if (order + s.mirrors[j] > stack_.max_order) continue;
        sums = sums_of(order + s.mirrors[j]);
      }
      const Direction wo{s.x[j], s.y[j], s.z[j]};
      const double way = wo.z > 0 ? y : l.depth - y;
      const double tau = s.rate[j] > 0 ? way * s.rate[j] : 0;
      const PhaseValue p = lobe.density(wo);
      const double share_aimed = share_.of([&] { return p.density; });
      const double transport =
          share_aimed * p.density * std::exp(-tau) * s.through[j] / std::abs(wo.z);
      checksum += transport;
      for (int c = 0; c < C; ++c) {
        double share = weight[c] * l.albedo[c] * transport;
        if (l.fresnel) share *= l.f0[c] + (1 - l.f0[c]) * p.schlick;
        if (mirrored) share *= s.mirrored[j][c];
        sums[c * count_ + s.target[j]] += share;
      }
    }
    finite_ = finite_ && std::isfinite(checksum);
  }

  /// Whether light that a mirror sends on has been scored already: else what leaves then counts.
  [[nodiscard]] bool sees_mirrors() const { return !cells_; }
  void substrate(const std::array<double, C>& weight, const std::array<double, C>& albedo,
                 std::uint64_t order);
  void substrate(const std::array<double, C>& weight, const SurfaceLaw& law, Direction wi,
                 std::uint64_t order, RandomStream& stream);
  [[nodiscard]] bool interface(int boundary, const Dielectric& at, Direction wi,
                               const std::array<double, C>& weight, std::uint64_t order,
                               RandomStream& stream);
  void leave(Direction wo, const std::array<double, C>& weight, std::uint64_t order, bool open) {
    if (open && cells_) AnalogScorer<C>(*cells_, tally_).leave(wo, weight, order, true);
  }
  [[nodiscard]] bool finite() const { return finite_; }

 private:
  [[nodiscard]] double* sums_of(std::uint64_t order) {
    return tally_.f.data() + static_cast<std::size_t>(order_slot(order)) * C * count_;
  }
  /// The ways of the walk that has begun, traced when they are asked for.
  [[nodiscard]] const ExitPaths& ways();

  const BoundaryStack& stack_;
  const CellTargets* cells_ = nullptr;
  BatchTally& tally_;
  AimedShare share_;
  std::optional<CellDirections> redrawn_;
  std::size_t count_;
  std::vector<double> x_, y_, z_, inverse_mu_;
  ExitPaths ways_;
  std::uint64_t seed_ = 0, group_ = 0;
  bool traced_ = false;
  bool finite_ = true;
};

}  // namespace lamella
