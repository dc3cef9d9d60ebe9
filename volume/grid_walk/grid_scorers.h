#pragma once

#include <cmath>
#include <memory>

#include "volume/grid_walk/grid_lattice.h"
#include "volume/grid_walk/grid_stack.h"
#include "volume/grid_walk/shadow_rays.h"
#include "volume/walk/departures.h"
#include "volume/walk/walk_lattice.h"

namespace lamella {

/// Where light is: a layer, the place in the tile, and the depth below the layer's top [mm].
struct Place {
  int layer;
  double x, y, z;
};

/// The share of light from w that reaches the stack's surface from a place, the product of that of
/// homogeneous layers and of in_grid(layer, place in it) for every layer with a grid.
template <class InGrid>
double transmittance(const GridWalkStack& stack, Place at, Direction w, const InGrid& in_grid) {
  // w points back to where the light comes from, so that it travels along -w.
  const bool down = w.z > 0;
  const int last = static_cast<int>(stack.layers.size()) - 1;
  double share = 1;
  while (at.layer >= 0 && at.layer <= last) {
    const GridWalkLayer& l = stack.layers[at.layer];
    const double length = (down ? l.thickness - at.z : at.z) / std::abs(w.z);
    if (l.grid) {
      share *= in_grid(l, at);
    } else if (l.density > 0) {
      const double area = sigma(*l.medium, w);
      if (area > 0) share *= std::exp(-l.density * area * length);
    }
    if (!(share > 0)) return 0;
    if (std::isinf(length)) return share;
    at.x -= w.x * length;
    at.y -= w.y * length;
    at.layer += down ? 1 : -1;
    if (at.layer >= 0 && at.layer <= last) at.z = down ? 0 : stack.layers[at.layer].thickness;
  }
  return share;
}

/// The same, estimated.
[[nodiscard]] double estimated_transmittance(const GridWalkStack& stack, const Place& at,
                                             Direction w, RandomStream& stream);

/// An event, or its lobe, in the frame of a voxel's flakes.
template <class Event>
struct TurnedEvent {
  Event event;
  const Frame<double>* frame;  // nullptr: the world's

  [[nodiscard]] PhaseValue density(Direction wo) const {
    return event.density(frame ? frame->to_local(wo) : wo);
  }
  // For many directions.
  [[nodiscard]] auto lobe() const {
    return TurnedEvent<std::remove_cvref_t<decltype(lobe_of(event))>>{lobe_of(event), frame};
  }
  [[nodiscard]] Scatter sample(RandomStream& stream) const {
    Scatter s = event.sample(stream);
    if (frame) s.wo = renormalized(frame->to_world(s.wo));
    return s;
  }
};
template <class Event>
TurnedEvent(Event, const Frame<double>*) -> TurnedEvent<Event>;

/// Scorers of the walk through grids: what an event sends straight out is worth `Transmittance`
/// along the way, which is asked for only where it is scored. kFirstFlightByVoxels: whether a
/// lattice's first flight goes voxel by voxel (fly_by_voxels), which counted cells gain nothing by.
template <int C>
struct GridAnalogScorer {
  static constexpr bool kFirstFlightByVoxels = false;
  AnalogScorer<C> analog;

  void begin_walk(std::uint64_t, std::uint64_t) {}
  template <class Event>
  void event(const Place&, const Event&, const std::array<double, C>&, const GridWalkLayer*,
             const std::array<double, C>&, std::uint64_t, WalkLattice::Point, RandomStream&) {}
  void leave(Direction wo, const std::array<double, C>& weight, std::uint64_t order, bool delta) {
    analog.leave(wo, weight, order, delta);
  }
  [[nodiscard]] bool finite() const { return true; }
};

/// Keeps what leaves.
template <int C>
struct GridDepartures : DepartureScorer {
  static constexpr bool kFirstFlightByVoxels = false;
  using DepartureScorer::DepartureScorer;
  template <class Event>
  void event(const Place&, const Event&, const std::array<double, C>&, const GridWalkLayer*,
             const std::array<double, C>&, std::uint64_t, WalkLattice::Point, RandomStream&) {}
};

template <int C>
struct GridNullScorer {
  static constexpr bool kFirstFlightByVoxels = false;
  void begin_walk(std::uint64_t, std::uint64_t) {}
  template <class Event>
  void event(const Place&, const Event&, const std::array<double, C>&, const GridWalkLayer*,
             const std::array<double, C>&, std::uint64_t, WalkLattice::Point, RandomStream&) {}
  void leave(Direction, const std::array<double, C>&, std::uint64_t, bool) {}
  [[nodiscard]] bool finite() const { return true; }
};

/// Next-event estimation. A way out through voxels is dear: on cells, each event sends its light to
/// one column of every row, for all of the row's. One number draws the columns, each of them a
/// golden section of the circle beside that of the row above. Ways through one grid wait until they
/// fill lanes, where there are any.
template <int C>
class GridNextEventScorer {
 public:
  static constexpr bool kFirstFlightByVoxels = true;

  GridNextEventScorer(const GridWalkStack& stack, const ShadowTables& tables, std::uint64_t seed,
                      const CellTargets& cells, const WalkLattice* lattice, BatchTally& tally)
      : GridNextEventScorer(stack, tables, seed, tally) {
    lattice_ = lattice;
    cells_ = &cells;
    columns_.resize(cells.grid.columns());
    rows_.resize(cells.grid.rows());
  }
  GridNextEventScorer(const GridWalkStack& stack, const ShadowTables& tables, std::uint64_t seed,
                      const std::vector<Direction>& points, BatchTally& tally)
      : GridNextEventScorer(stack, tables, seed, tally) {
    points_ = &points;
  }

  void begin_walk(std::uint64_t seed, std::uint64_t index) {
    if (queue_) queue_->begin_walk(index);
    if (!cells_) return;
    RandomStream stream(seed, index, StreamPurpose::targets);
    if (lattice_) {
      const WalkLattice::Point point = lattice_->point(index);
      stream.put(point.word(0, kLatticeTargetWord), point.word(0, kLatticeTargetWord + 1));
    }
    const double u_mu = stream.uniform(), u_phi = stream.uniform();
    const CellGrid& grid = cells_->grid;
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      const double phi =
          cells_->incident_azimuth + 2 * kPi * (static_cast<double>(k) + u_phi) / grid.phi_cells;
      columns_[k] = {std::cos(phi), std::sin(phi), 0};
    }
    for (std::size_t k = 0; k < rows_.size(); ++k) {
      const double mu2 = (grid.mu_cells - static_cast<double>(k) - u_mu) / grid.mu_cells;
      rows_[k] = {std::sqrt(mu2), std::sqrt(1 - mu2)};
    }
  }

  // layer: nullptr at the substrate. albedo: of the event, without Fresnel's factor.
  template <class Event>
  void event(const Place& at, const Event& event, const std::array<double, C>& weight,
             const GridWalkLayer* layer, const std::array<double, C>& albedo, std::uint64_t order,
             WalkLattice::Point lattice, RandomStream& stream) {
    const auto& lobe = lobe_of(event);
    const auto score = [&](int target, int count, Direction wo, double factor) {
      const PhaseValue p = lobe.density(wo);
      if (!(p.density > 0)) {
        finite_ = finite_ && p.density == 0;
        return;
      }
      const double transport = factor * p.density / std::abs(wo.z);
      std::array<double, C> worth;
      for (int c = 0; c < C; ++c) {
        worth[c] = weight[c] * albedo[c] * transport;
        if (layer && layer->fresnel) worth[c] *= layer->f0[c] + (1 - layer->f0[c]) * p.schlick;
        finite_ = finite_ && std::isfinite(worth[c]);
      }
      double* sums =
          tally_.f.data() + static_cast<std::size_t>(order_slot(order)) * C * count + target;
      send(at, -wo, worth, sums, count, stream);
    };
    if (!cells_) {
      const int count = static_cast<int>(points_->size());
      for (int j = 0; j < count; ++j)
        if (layer || (*points_)[j].z > 0) score(j, count, (*points_)[j], 1);
      return;
    }
    const CellGrid& grid = cells_->grid;
    const int columns = grid.columns(), count = cells_->count();
    double u = lattice.has(order)
                   ? RandomStream::uniform_of(lattice.word(order, kLatticeTargetWord))
                   : stream.uniform();
    for (const bool up : {true, false}) {
      if (!up && (!cells_->both_sides || !layer)) break;
      for (int row = 0; row < grid.rows(); ++row) {
        const int column = std::min(static_cast<int>(u * columns), columns - 1);
        u += kGoldenSection;
        if (u >= 1) u -= 1;
        const auto [mu, s] = rows_[row];
        const Direction wo{s * columns_[column].x, s * columns_[column].y, up ? mu : -mu};
        score(row * columns + column + (up ? 0 : grid.cells()), count, wo, columns);
      }
    }
  }

  void leave(Direction wo, const std::array<double, C>& weight, std::uint64_t order, bool delta) {
    if (delta && cells_) AnalogScorer<C>(*cells_, tally_).leave(wo, weight, order, true);
  }
  void end_batch() {
    if (queue_) queue_->flush();
  }
  [[nodiscard]] bool finite() const { return finite_; }

 private:
  static constexpr double kGoldenSection = 0.6180339887498949;

  GridNextEventScorer(const GridWalkStack& stack, const ShadowTables& tables, std::uint64_t seed,
                      BatchTally& tally)
      : stack_(stack), tally_(tally) {
    if (tables.on_lanes()) queue_ = std::make_unique<ShadowQueue<C>>(tables, seed);
  }

  // Adds what arrives outside, from a place along -w, to sums[c stride].
  void send(const Place& at, Direction w, std::array<double, C> worth, double* sums,
            std::size_t stride, RandomStream& stream) {
    double share = 0;
    const auto wait = [&](const GridWalkLayer& l, const Place& in) {
      queue_->push(*l.grid, {in.x, in.y, l.thickness - in.z, w}, worth, sums, stride);
    };
    if (queue_ && ShadowTables::takes(w)) {
      if (stack_.layers.size() == 1 && at.layer == 0) return wait(stack_.layers[0], at);
      const GridWalkLayer* crossed = nullptr;
      Place in = at;
      int grids = 0;
      share = transmittance(stack_, at, w, [&](const GridWalkLayer& l, const Place& place) {
        crossed = &l;
        in = place;
        ++grids;
        return 1.0;
      });
      if (grids == 1 && share > 0) {
        for (double& x : worth) x *= share;
        return wait(*crossed, in);
      }
      if (grids > 1) share = estimated_transmittance(stack_, at, w, stream);
    } else {
      share = estimated_transmittance(stack_, at, w, stream);
    }
    for (int c = 0; c < C; ++c) sums[c * stride] += worth[c] * share;
  }

  const GridWalkStack& stack_;
  const CellTargets* cells_ = nullptr;
  const std::vector<Direction>* points_ = nullptr;
  const WalkLattice* lattice_ = nullptr;
  BatchTally& tally_;
  std::unique_ptr<ShadowQueue<C>> queue_;
  // Of the walk's directions: cosine and sine of phi by column, of theta by row.
  struct Row {
    double mu, s;
  };
  std::vector<Direction> columns_;
  std::vector<Row> rows_;
  bool finite_ = true;
};

}  // namespace lamella
