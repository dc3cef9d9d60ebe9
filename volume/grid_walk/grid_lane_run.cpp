#include "volume/grid_walk/grid_lane_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "phase/medium/medium.h"
#include "phase/random/lattice.h"
#include "volume/grid_walk/grid_march.h"
#include "volume/grid_walk/grid_stack.h"
#include "volume/grid_walk/turned_flakes.h"
#include "volume/lanes/lane_run.h"
#include "volume/walk/walk.h"
#include "volume/walk/walk_batches.h"

namespace lamella {
namespace {

constexpr std::uint64_t kHalf = std::uint64_t{1} << 32;
// Of the tile or the thickness, in mean free paths: a place is rounded to 1e-3 of one.
constexpr double kMostAcross = 1e4;

// Walks from the one with that index on that a task can have.
int walks_of_task(std::uint64_t index, std::uint64_t stride, std::uint64_t walks) {
  const std::uint64_t same_half = (kHalf - 1 - index % kHalf) / stride + 1;
  return static_cast<int>(std::min<std::uint64_t>({walks, same_half, kGridWalks}));
}

std::optional<std::string> why_not_flakes(const DensityGrid& grid, double depth) {
  if (!grid.has_orientation()) return why_not_lane_medium(grid.palette()[0], depth);
  for (const Medium& medium : grid.palette())
    if (sigma(medium, {0, 0, 1}) < kThinnestTurnedFiber * sigma(medium, {1, 0, 0}))
      return "turned fibers this narrow ask for double";
  return std::nullopt;
}

}  // namespace

// What lanes write, for the walks of one task.
struct GridLaneRun::Ends {
  explicit Ends(GridWalkTask& task)
      : words(std::make_unique_for_overwrite<std::uint32_t[]>(3 * kGridWalkRows)),
        floats(std::make_unique<float[]>(9 * kGridWalkRows)) {
    rows.end = words.get();
    rows.order = rows.end + kGridWalkRows;
    rows.cell = rows.order + kGridWalkRows;
    float* at = floats.get();
    const auto next = [&] {
      float* const row = at;
      at += kGridWalkRows;
      return row;
    };
    for (float*& row : rows.wi) row = next();
    for (float*& row : rows.weight) row = next();
    for (float*& row : light) row = next();
    task.ends = rows;
  }

  std::unique_ptr<std::uint32_t[]> words;
  std::unique_ptr<float[]> floats;
  GridWalkEnds rows;
  float* light[3];
};

std::optional<std::string> GridLaneRun::why_not(const Stack& stack, const Plan& plan,
                                                const GridRayTable* table) {
  if (plan.isa == Isa::scalar) return "the scalar kernel was asked for";
  if (plan.layers.size() != 1)
    return "walks through density grids have a kernel on lanes for one layer only";
  if (!table)
    return "lanes have no table for a grid of one-sided flakes that are turned, of roughness "
           "alone, or of very many voxels";
  const Layer& layer = stack.layers[plan.layers[0]];
  const DensityGrid& grid = *plan.grids[plan.layers[0]];
  if (grid.has_albedo()) return "lanes have no albedo grids";
  if (stack.substrate && !stack.substrate->model.empty())
    return fmt::format("lanes have no kernel for a substrate that reflects by {}",
                       stack.substrate->model);
  if (plan.max_order > 1000000000) return "orders above 1e9 are not counted on lanes";
  float largest = 0;
  for (std::size_t k = 0; k < table->block_entries.size(); k += 4)
    largest = std::max(largest, table->block_entries[k]);
  const double across = std::max({layer.grid->size_x, layer.grid->size_y, layer.thickness}) *
                        layer.density * static_cast<double>(largest);
  if (!(across <= kMostAcross))
    return fmt::format("a tile of {:g} mean free paths is more than float resolves", across);
  return why_not_flakes(grid, layer.depth());
}

std::unique_ptr<GridLaneRun> GridLaneRun::make(const Stack& stack, const Plan& plan,
                                               Direction incident, std::uint64_t seed,
                                               const CellTargets* cells) {
  if (plan.isa == Isa::scalar || plan.layers.size() != 1) return nullptr;
  std::shared_ptr<const GridRayTable> table = make_ray_table(*plan.grids[plan.layers[0]]);
  if (why_not(stack, plan, table.get())) return nullptr;
  return std::unique_ptr<GridLaneRun>(
      new GridLaneRun(stack, plan, incident, seed, cells, std::move(table)));
}

GridLaneRun::GridLaneRun(const Stack& stack, const Plan& plan, Direction incident,
                         std::uint64_t seed, const CellTargets* cells,
                         std::shared_ptr<const GridRayTable> table)
    : table_(std::move(table)),
      setting_(stack, plan, incident, seed),
      incident_(incident),
      sampling_(plan.sampling),
      channels_(plan.channels),
      walk_(walk_grid_lanes_for(plan.isa)) {
  const DensityGrid& grid = *plan.grids[plan.layers[0]];
  const Medium& medium = grid.palette()[0];
  task_.walk = setting_.walk;
  task_.grid = lane_grid_of(*table_);
  const Direction h = grid.voxel_size();
  const double per_mm[3] = {1 / h.x, 1 / h.y, 1 / h.z};
  for (int a = 0; a < 3; ++a) task_.per_mm[a] = static_cast<float>(per_mm[a]);
  task_.density = static_cast<float>(grid.layer_density());
  const bool turned = table_->turned;
  task_.bound = static_cast<float>(kMajorantMargin *
                                   (turned ? grid.layer_density() * table_->largest_sigma : 1));
  task_.scaled = !turned && traits(medium).has_axis;
  task_.mirror = std::holds_alternative<MirrorFlakes<Sggx>>(medium);
  if (!cells) return;
  cells_ = *cells;
  LaneCells& to = task_.cells;
  to.on = true;
  to.folded = cells->grid.folded;
  to.rows = cells->grid.rows();
  to.columns = cells->grid.columns();
  to.phi_cells = cells->grid.phi_cells;
  to.azimuth_turns = static_cast<float>(cells->incident_azimuth / (2 * kPi));
}

std::uint64_t GridLaneRun::follow(GridWalkTask& task, Ends& ends) const {
  const GridWalkCount count = walk_(task);
  if (count.majorant_too_low) throw MajorantError();
  for (int j = 0; j < task.count; ++j) {
    float sum = 0;
    for (const float* row : ends.rows.wi) sum += row[j];
    for (int c = 0; c < channels_; ++c) sum += ends.rows.weight[c][j];
    if (!std::isfinite(sum))
      throw NonFiniteError(task.walk.seed,
                           kHalf * task.index_high + task.index_low +
                               static_cast<std::uint64_t>(j) * task.index_stride,
                           incident_);
  }
  return count.collisions;
}

void GridLaneRun::count(int batch, std::uint64_t from, std::uint64_t to, BatchTally& tally) const {
  GridWalkTask task = task_;
  Ends ends(task);
  LatticeNumbers lattice;
  std::uint64_t of_lattice = kHalf;  // none
  task.index_stride = kBatches;
  while (from < to) {
    const std::uint64_t index = walk_of_batch(batch, from);
    std::uint64_t walks = to - from;
    if (sampling_ == Sampling::rqmc) {
      walks = std::min(walks, kLatticePoints - from % kLatticePoints);
      if (of_lattice != from / kLatticePoints) {
        of_lattice = from / kLatticePoints;
        lattice = lattice_of_batch(
            lattice_shift(task.walk.seed, static_cast<std::uint32_t>(batch), from));
        task.walk.lattice = &lattice;
      }
      task.point = lattice_point(from);
    }
    task.index_low = static_cast<std::uint32_t>(index);
    task.index_high = static_cast<std::uint32_t>(index >> 32);
    task.count = walks_of_task(index, kBatches, walks);
    tally.collisions += follow(task, ends);
    if (channels_ == 1)
      add<1>(task, ends, tally);
    else
      add<3>(task, ends, tally);
    from += static_cast<std::uint64_t>(task.count);
  }
}

template <int C>
void GridLaneRun::add(const GridWalkTask& task, const Ends& ends, BatchTally& tally) const {
  const GridWalkEnds& rows = ends.rows;
  const std::size_t cells = cells_ ? cells_->grid.cells() : 0;
  const std::size_t targets = cells_ ? cells_->count() : 0;
  const double scale = cells_ ? 1 / cells_->grid.projected_solid_angle() : 0;
  EnergySums& energy = tally.energy;
  for (int j = 0; j < task.count; ++j) {
    PathWeight<C> weight;
    for (int c = 0; c < C; ++c) weight.value[c] = rows.weight[c][j];
    // What a walk has lost on its way is absorbed.
    const auto end = static_cast<WalkEnd>(rows.end[j]);
    if (end == WalkEnd::absorbed) weight.value.fill(0);
    for (int c = 0; c < C; ++c) energy.absorbed[c] += 1 - weight.value[c];
    if (end == WalkEnd::unresolved) weight.add_to(energy.unresolved);
    if (end != WalkEnd::up && end != WalkEnd::down) continue;
    const bool down = end == WalkEnd::down;
    const std::uint32_t order = rows.order[j];
    weight.leave(energy, down, order, order == 0);
    if (order == 0 || !cells_ || (down && !cells_->both_sides)) continue;
    double* f =
        tally.f.data() + order_slot(order) * C * targets + (down ? cells : 0) + rows.cell[j];
    for (int c = 0; c < C; ++c) f[c * targets] += scale * weight.value[c];
  }
  tally.walks += static_cast<std::uint64_t>(task.count);
}

WalkSamples GridLaneRun::take(IncidentLaw law, std::uint64_t from, std::uint64_t to) const {
  WalkSamples samples;
  samples.channels = channels_;
  samples.walks = to - from;
  GridWalkTask task = task_;
  Ends ends(task);
  const bool drawn = law != IncidentLaw::fixed;
  if (drawn) std::copy(std::begin(ends.light), std::end(ends.light), task.light);
  std::array<Direction, kGridWalks> light;
  light.fill(incident_);
  while (from < to) {
    task.index_low = static_cast<std::uint32_t>(from);
    task.index_high = static_cast<std::uint32_t>(from >> 32);
    task.count = walks_of_task(from, 1, to - from);
    for (int j = 0; drawn && j < task.count; ++j) {
      light[j] =
          drawn_incident(law, task.walk.seed, from + static_cast<std::uint64_t>(j), kGridGrazing);
      ends.light[0][j] = static_cast<float>(light[j].x);
      ends.light[1][j] = static_cast<float>(light[j].y);
      ends.light[2][j] = static_cast<float>(light[j].z);
    }
    (void)follow(task, ends);
    for (int j = 0; j < task.count; ++j) {
      const auto end = static_cast<WalkEnd>(ends.rows.end[j]);
      if (end != WalkEnd::up && end != WalkEnd::down) continue;
      float weights[3];
      for (int c = 0; c < channels_; ++c) weights[c] = ends.rows.weight[c][j];
      const std::uint32_t order = ends.rows.order[j];
      const auto& wi = ends.rows.wi;
      samples.add(light[j], {-wi[0][j], -wi[1][j], -wi[2][j]}, weights, order, end == WalkEnd::up,
                  order == 0);
    }
    from += static_cast<std::uint64_t>(task.count);
  }
  return samples;
}

}  // namespace lamella
