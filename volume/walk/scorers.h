#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "phase/random/random.h"
#include "volume/result/cell_grid.h"
#include "volume/walk/walk.h"

namespace lamella {

/// Where a cell of the grid stands among the targets of a tally: first the upper hemisphere's
/// cells, then, if light can leave below, the lower one's.
struct CellTargets {
  CellGrid grid;
  double incident_azimuth = 0;
  bool both_sides = false;

  [[nodiscard]] int count() const { return grid.cells() * (both_sides ? 2 : 1); }
  /// The target that a leaving direction falls into, or -1 (below a stack where light cannot
  /// leave).
  [[nodiscard]] int find(Direction wo) const;
};

/// Scores nothing: for the energies alone.
struct NullScorer {
  template <std::size_t C>
  void leave(Direction, const std::array<double, C>&, std::uint64_t, bool) {}
  template <class Event, std::size_t C>
  void collision(const WalkLayer&, int, double, const Event&, const std::array<double, C>&,
                 std::uint64_t) {}
  template <std::size_t C>
  void substrate(const std::array<double, C>&, const std::array<double, C>&, std::uint64_t) {}
  void begin_walk(std::uint64_t, std::uint64_t) {}
  [[nodiscard]] bool finite() const { return true; }
};

/// Analog estimator: a walk that leaves counts in the cell of its direction.
template <int C>
class AnalogScorer {
 public:
  AnalogScorer(const CellTargets& targets, BatchTally& tally)
      : targets_(targets), tally_(tally), scale_(1 / targets.grid.projected_solid_angle()) {}

  void leave(Direction wo, const std::array<double, C>& weight, std::uint64_t order, bool) {
    const int target = targets_.find(wo);
    if (target < 0) return;
    const std::size_t count = targets_.count();
    double* f = tally_.f.data() + order_slot(order) * C * count + target;
    for (int c = 0; c < C; ++c) f[c * count] += scale_ * weight[c];
  }
  template <class Event>
  void collision(const WalkLayer&, int, double, const Event&, const std::array<double, C>&,
                 std::uint64_t) {}
  void substrate(const std::array<double, C>&, const std::array<double, C>&, std::uint64_t) {}
  void begin_walk(std::uint64_t, std::uint64_t) {}
  [[nodiscard]] bool finite() const { return true; }

 private:
  const CellTargets& targets_;
  BatchTally& tally_;
  double scale_;
};

/// The directions of cell means by next-event estimation: one per cell, stratified, redrawn for
/// every walk at the same place within every cell.
class CellDirections {
 public:
  explicit CellDirections(const CellTargets& targets);
  /// Writes the directions of all targets of that walk, and 1 / |mu|.
  void redraw(std::uint64_t seed, std::uint64_t index, std::vector<double>& x,
              std::vector<double>& y, std::vector<double>& z, std::vector<double>& inverse_mu);

 private:
  const CellTargets& targets_;
  std::vector<double> column_cos_, column_sin_;
};

/// Outgoing directions of next-event estimation and the extinction along them: structure of arrays,
/// the upward directions first.
struct TargetDirections {
  int up = 0;  ///< how many go up
  std::vector<double> x, y, z, inverse_mu;
  /// Per layer: sigma(-w_o) / |mu_o|, and the optical depth of the layers between that one and the
  /// exit.
  std::vector<std::vector<double>> rate, beyond;

  [[nodiscard]] int count() const { return static_cast<int>(x.size()); }
  void resize(int count, std::size_t layers);
  /// Fills rate and beyond for all directions. row_length: how many neighbouring directions share
  /// their mu and hence, where the stack is symmetric about z, their areas (1: none do).
  void trace(const WalkStack& stack, int row_length);
};

/// Next-event estimator: every event sends its share to every target, attenuated on the way out;
/// the sum is an estimate of f at the target's direction.
template <int C>
class NextEventScorer {
 public:
  /// Cell means: one direction per cell, stratified, redrawn for every walk.
  NextEventScorer(const CellTargets& cells, const WalkStack& stack, BatchTally& tally);
  /// Values at given directions; those that go up first.
  NextEventScorer(const std::vector<Direction>& points, const WalkStack& stack, BatchTally& tally);

  void begin_walk(std::uint64_t seed, std::uint64_t index);

  template <class Event>
  void collision(const WalkLayer& l, int layer, double y, const Event& event,
                 const std::array<double, C>& weight, std::uint64_t order) {
    const int count = directions_.count();
    double* sums = tally_.f.data() + static_cast<std::size_t>(order_slot(order)) * C * count;
    const double* rate = directions_.rate[layer].data();
    const double* beyond = directions_.beyond[layer].data();
    double checksum = 0;
    const auto& lobe = lobe_of(event);
    // Fresnel's factor costs a root: where there is none, it is no part of the loop.
    const auto range = [&](int from, int to, double way, auto fresnel) {
      for (int j = from; j < to; ++j) {
        const Direction wo{directions_.x[j], directions_.y[j], directions_.z[j]};
        const double tau = beyond[j] + (rate[j] > 0 ? way * rate[j] : 0);
        const PhaseValue p = lobe.density(wo);
        const double transport = p.density * std::exp(-tau) * directions_.inverse_mu[j];
        checksum += transport;
        for (int c = 0; c < C; ++c) {
          double share = weight[c] * l.albedo[c] * transport;
          if constexpr (fresnel.value) share *= l.f0[c] + (1 - l.f0[c]) * p.schlick;
          sums[c * count + j] += share;
        }
      }
    };
    const auto both = [&](auto fresnel) {
      range(0, directions_.up, y, fresnel);
      range(directions_.up, count, l.depth - y, fresnel);
    };
    if (l.fresnel)
      both(std::true_type());
    else
      both(std::false_type());
    finite_ = finite_ && std::isfinite(checksum);
  }

  void substrate(const std::array<double, C>& weight, const std::array<double, C>& albedo,
                 std::uint64_t order) {
    const int count = directions_.count();
    double* sums = tally_.f.data() + static_cast<std::size_t>(order_slot(order)) * C * count;
    for (int j = 0; j < directions_.up; ++j) {
      double tau = 0;
      if (!directions_.rate.empty())
        tau = directions_.beyond.back()[j] + last_depth_ * directions_.rate.back()[j];
      const double transport = lambert_radiance(std::exp(-tau));
      for (int c = 0; c < C; ++c) sums[c * count + j] += weight[c] * albedo[c] * transport;
    }
  }

  /// Light that a delta event sends out cannot be aimed at a target: it counts in its cell.
  void leave(Direction wo, const std::array<double, C>& weight, std::uint64_t order,
             bool after_delta) {
    if (!after_delta || !cells_) return;
    AnalogScorer<C>(*cells_, tally_).leave(wo, weight, order, true);
  }
  [[nodiscard]] bool finite() const { return finite_; }

 private:
  const CellTargets* cells_ = nullptr;
  std::optional<CellDirections> cell_directions_;
  const WalkStack& stack_;
  BatchTally& tally_;
  TargetDirections directions_;
  double last_depth_ = 0;
  bool symmetric_ = false;
  bool finite_ = true;
};

}  // namespace lamella
