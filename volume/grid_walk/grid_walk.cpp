#include "volume/grid_walk/grid_walk.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "volume/grid_walk/grid_march.h"
#include "volume/grid_walk/shadow_rays.h"
#include "volume/walk/path_weight.h"
#include "volume/walk/walk.h"
#include "volume/walk/walk_lattice.h"

namespace lamella {

double common_period(const std::vector<double>& periods) {
  constexpr int kMost = 1000;
  for (int times = 1; times <= kMost && !periods.empty(); ++times) {
    const double length = periods[0] * times;
    if (std::all_of(periods.begin(), periods.end(), [&](double p) {
          const double count = length / p;
          return count > 0.5 && count < kMost + 0.5 &&
                 std::abs(count - std::round(count)) <= 1e-9 * count;
        }))
      return length;
  }
  std::string list;
  for (const double p : periods) list += (list.empty() ? "" : ", ") + to_text(p);
  throw std::invalid_argument(
      fmt::format("key \"size\": found the periods {} mm; allowed: periods of which a length holds "
                  "whole numbers, at most {}",
                  list, kMost));
}

GridWalkStack::GridWalkStack(const Stack& stack, const Plan& plan)
    : has_substrate(stack.substrate.has_value()),
      substrate_albedo{},
      max_order(plan.max_order),
      owned(plan.grids) {
  const auto channels = [](Rgb c) { return std::array<double, 3>{c.r, c.g, c.b}; };
  std::vector<double> x, y;
  for (const int k : plan.layers) {
    const Layer& layer = stack.layers[k];
    const DensityGrid* grid = owned[k].get();
    layers.push_back({&layer.medium, grid, layer.thickness, layer.density, channels(layer.albedo),
                      channels(layer.f0), layer.f0 != Rgb(1)});
    if (!grid) continue;
    x.push_back(layer.grid->size_x);
    y.push_back(layer.grid->size_y);
  }
  try {
    tile_x = common_period(x);
    tile_y = common_period(y);
  } catch (const std::invalid_argument& error) {
    std::string where;
    for (const int k : plan.layers)
      if (owned[k]) where = stack.layers[k].grid->where;
    throw std::invalid_argument(where + ": " + error.what());
  }
  if (stack.substrate) substrate_albedo = channels(stack.substrate->albedo);
}

namespace {

constexpr double kGoldenSection = 0.6180339887498949;

// Words of a lattice's step: the flight, four of the event, the acceptance of a first tentative
// collision, and the place that next-event estimation aims at (step 0: within the cells; events:
// the columns). Step 0 begins the walk: its event is the place in the tile.
constexpr int kFlightWord = 0, kEventWord = 1, kAcceptanceWord = 5;

// Where light is: a layer, the place in the tile, and the depth below the layer's top [mm].
struct Place {
  int layer;
  double x, y, z;
};

// The share of light from w that reaches the stack's surface from a place, the product of that of
// homogeneous layers and of in_grid(layer, place in it) for every layer with a grid.
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

// The same, estimated.
double estimated_transmittance(const GridWalkStack& stack, const Place& at, Direction w,
                               RandomStream& stream) {
  return transmittance(stack, at, w, [&](const GridWalkLayer& l, const Place& in) {
    return std::visit(
        [&]<class M>(const M&) {
          return ratio_tracked<M>(*l.grid, in.x, in.y, l.thickness - in.z, w, stream);
        },
        l.grid->palette()[0]);
  });
}

// An event, or its lobe, in the frame of a voxel's flakes.
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

// Scorers of the walk through grids: what an event sends straight out is worth `Transmittance`
// along the way, which is asked for only where it is scored. kFirstFlightByVoxels: whether a
// lattice's first flight goes voxel by voxel (fly_by_voxels), which counted cells gain nothing by.
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

// Keeps what leaves.
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

// Next-event estimation. A way out through voxels is dear: on cells, each event sends its light to
// one column of every row, for all of the row's. One number draws the columns, each of them a
// golden section of the circle beside that of the row above. Ways through one grid wait until they
// fill lanes, where there are any.
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

// `walk` with a place in the tile: the same ledger, the same chance of survival. The numbers of the
// first steps are the point's, where it has any.
template <int C, class Scorer>
void walk_in_grids(const GridWalkStack& stack, Direction incident, std::uint64_t seed,
                   std::uint64_t index, WalkLattice::Point lattice, Scorer& scorer,
                   BatchTally& tally) {
  RandomStream stream(seed, index, StreamPurpose::walk);
  lattice.put(0, kEventWord, stream);
  EnergySums& energy = tally.energy;
  const int last = static_cast<int>(stack.layers.size()) - 1;
  Direction wi = incident;  // points back to where the light comes from
  PathWeight<C> weight;
  Place at{wi.z > 0 ? 0 : last, stack.tile_x * stream.uniform(), stack.tile_y * stream.uniform(),
           0};
  if (wi.z < 0) at.z = stack.layers[last].thickness;
  std::uint64_t order = 0;
  bool only_delta = true, last_delta = false;

  for (;;) {
    if (lattice.has(order))
      stream.put(lattice.word(order, kFlightWord), lattice.word(order, kAcceptanceWord));
    double remaining = stream.exponential();
    const bool down = wi.z > 0;
    bool endless = false;
    GridFlight flight;
    while (at.layer >= 0 && at.layer <= last) {
      const GridWalkLayer& l = stack.layers[at.layer];
      flight.end = Flight::left;
      if (l.grid) {
        flight = std::visit(
            [&]<class M>(const M&) {
              if (Scorer::kFirstFlightByVoxels && order == 0 && lattice.has(0))
                return fly_by_voxels<M>(*l.grid, at.x, at.y, l.thickness - at.z, wi, remaining);
              return fly<M>(*l.grid, at.x, at.y, l.thickness - at.z, wi, remaining, stream);
            },
            l.grid->palette()[0]);
      } else {
        flight.length = (down ? l.thickness - at.z : at.z) / std::abs(wi.z);
        const double extinction = l.density * sigma(*l.medium, wi);
        if (extinction > 0) {
          const double free = remaining / extinction;
          if (free < flight.length) {
            flight.end = Flight::collided;
            flight.length = free;
          } else {
            remaining = std::max(remaining - extinction * flight.length, 1e-300);
          }
        }
      }
      endless = flight.end == Flight::endless;
      if (endless || !std::isfinite(flight.length)) break;  // in a half space: for good
      at.x -= wi.x * flight.length;
      at.y -= wi.y * flight.length;
      if (!(at.x >= 0 && at.x < stack.tile_x))
        at.x -= stack.tile_x * std::floor(at.x / stack.tile_x);
      if (!(at.y >= 0 && at.y < stack.tile_y))
        at.y -= stack.tile_y * std::floor(at.y / stack.tile_y);
      if (flight.end == Flight::collided) {
        at.z = std::clamp(at.z + wi.z * flight.length, 0.0, l.thickness);
        break;
      }
      at.layer += down ? 1 : -1;
      if (at.layer >= 0 && at.layer <= last) at.z = down ? 0 : stack.layers[at.layer].thickness;
    }

    const bool collides = flight.end == Flight::collided;
    if (!endless && !collides && !(down && stack.has_substrate)) {  // leaves the stack
      weight.leave(energy, down, order, only_delta);
      tell_departure(scorer, -wi, weight.value, order, only_delta);
      if (!only_delta) scorer.leave(-wi, weight.value, order, last_delta);
      break;
    }
    if (endless || order == stack.max_order) {
      weight.add_to(energy.unresolved);
      break;
    }
    ++order;

    if (!collides) {  // the substrate
      only_delta = last_delta = false;
      std::array<double, C> kept;
      for (int c = 0; c < C; ++c) kept[c] = stack.substrate_albedo[c];
      at.layer = last;
      at.z = stack.layers[last].thickness;
      lattice.put(order, kEventWord, stream);
      const Direction wo = kLambertSubstrate.sample(stream).wo;
      scorer.event(at, kLambertSubstrate, weight.value, nullptr, kept, order, lattice, stream);
      if (!weight.survives(kept, order, energy, stream)) break;
      wi = -wo;
      continue;
    }

    ++tally.collisions;
    const GridWalkLayer& l = stack.layers[at.layer];
    std::array<double, C> albedo;
    for (int c = 0; c < C; ++c) albedo[c] = l.albedo[c];
    Frame<double> frame;
    const bool turned = l.grid && l.grid->has_orientation();
    const Medium* medium = l.medium;
    if (l.grid) {
      medium = &l.grid->palette()[l.grid->palette_index(flight.voxel)];
      if (turned) frame = frame_around(normalized(l.grid->axis(flight.voxel)));
      if (l.grid->has_albedo()) {
        const auto a = l.grid->albedo(flight.voxel);
        for (int c = 0; c < C; ++c) albedo[c] *= a[c];
      }
    }
    const bool alive = std::visit(
        [&](const auto& m) {
          lattice.put(order, kEventWord, stream);
          const TurnedEvent event{m.collide(turned ? frame.to_local(wi) : wi, stream),
                                  turned ? &frame : nullptr};
          const Scatter scatter = event.sample(stream);
          last_delta = m.is_delta();
          if (!last_delta) {
            only_delta = false;
            scorer.event(at, event, weight.value, &l, albedo, order, lattice, stream);
          }
          const auto kept = kept_shares<C>(albedo, l, scatter.schlick);
          if (!weight.survives(kept, order, energy, stream)) return false;
          wi = -scatter.wo;
          return true;
        },
        *medium);
    if (!alive) break;
  }
  ++tally.walks;
  double check = wi.x + wi.y + wi.z + at.x + at.y + at.z;
  for (int c = 0; c < C; ++c) check += weight.value[c];
  if (!std::isfinite(check) || !scorer.finite()) throw NonFiniteError(seed, index, incident);
}

template <int C>
RunBatch runner_of(const std::shared_ptr<const GridWalkStack>& stack, Direction incident,
                   std::uint64_t seed, Estimator estimator, const CellTargets& targets,
                   const std::vector<Direction>* points, const Plan& plan,
                   std::vector<BatchTally>& batches) {
  const auto lattice =
      plan.sampling == Sampling::rqmc ? std::make_shared<const WalkLattice>(seed) : nullptr;
  const auto with = [&](const auto& make_scorer) {
    return batches_of_walks(
        seed, batches, make_scorer, [=](std::uint64_t index, auto& scorer, BatchTally& tally) {
          walk_in_grids<C>(*stack, incident, seed, index,
                           lattice ? lattice->point(index) : WalkLattice::Point(), scorer, tally);
        });
  };
  if (points && points->empty()) return with([](int) { return GridNullScorer<C>(); });
  if (!points && estimator == Estimator::analog)
    return with([&targets, &batches](int batch) {
      return GridAnalogScorer<C>{AnalogScorer<C>(targets, batches[batch])};
    });
  const auto tables = std::make_shared<const ShadowTables>(plan.isa, stack->owned);
  if (points)
    return with([=, &batches](int batch) {
      return GridNextEventScorer<C>(*stack, *tables, seed, *points, batches[batch]);
    });
  return with([=, &targets, &batches](int batch) {
    return GridNextEventScorer<C>(*stack, *tables, seed, targets, lattice.get(), batches[batch]);
  });
}

}  // namespace

void check_beside_grids(const char* what, Direction w) {
  if (std::abs(w.z) < kGridGrazing)
    throw std::invalid_argument(
        fmt::format("{}: found mu = {:.3g} on a stack with a density grid; allowed: |mu| >= {}",
                    what, w.z == kGrazingLimit ? 0 : w.z, kGridGrazing));
}

FollowWalk grid_follower(const Stack& stack, const Plan& plan, std::uint64_t seed) {
  const auto walked = std::make_shared<const GridWalkStack>(stack, plan);
  const auto with = [&]<int C>(std::integral_constant<int, C>) -> FollowWalk {
    return [walked, seed](Direction wi, std::uint64_t index, WalkSamples& to) {
      GridDepartures<C> scorer(wi, to);
      BatchTally spare;
      walk_in_grids<C>(*walked, wi, seed, index, {}, scorer, spare);
    };
  };
  return plan.channels == 1 ? with(std::integral_constant<int, 1>())
                            : with(std::integral_constant<int, 3>());
}

RunBatch grid_runner(const Stack& stack, const Plan& plan, Direction incident, std::uint64_t seed,
                     Estimator estimator, const CellTargets& targets,
                     const std::vector<Direction>* points, std::vector<BatchTally>& batches) {
  check_beside_grids("w_i", incident);
  if (points)
    for (const Direction& wo : *points) check_beside_grids("w_o", wo);
  const auto walked = std::make_shared<const GridWalkStack>(stack, plan);
  return plan.channels == 1
             ? runner_of<1>(walked, incident, seed, estimator, targets, points, plan, batches)
             : runner_of<3>(walked, incident, seed, estimator, targets, points, plan, batches);
}  // NOLINT(clang-analyzer-cplusplus.NewDeleteLeaks): std::function owns the runner

}  // namespace lamella
