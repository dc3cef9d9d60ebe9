#include "volume/grid_walk/shadow_rays.h"

#include <cmath>

#include "phase/medium/medium.h"
#include "phase/random/random.h"
#include "volume/grid_walk/grid_march.h"

namespace lamella {
namespace {

// Bits of a counter that name the stream's purpose; a ray's place among its walk's has the others.
constexpr int kPurposeBits = 4;

}  // namespace

ShadowTables::ShadowTables(Isa isa, const std::vector<std::shared_ptr<const DensityGrid>>& grids) {
  const auto follow = follow_shadow_rays_for(isa);
  if (!follow) return;
  for (const auto& grid : grids) {
    if (!grid) continue;
    auto table = make_ray_table(*grid);
    if (!table) return;
    tables_.emplace_back(grid.get(), std::move(table));
  }
  follow_ = follow;
}

const GridRayTable& ShadowTables::of(const DensityGrid& grid) const {
  for (const auto& [which, table] : tables_)
    if (which == &grid) return *table;
  throw std::logic_error("a grid without a table of rays");
}

template <int C>
void ShadowQueue<C>::push(const DensityGrid& grid, const ShadowRay& ray,
                          const std::array<double, C>& worth, double* sums, std::size_t stride) {
  if (count_ == kShadowRays || grid_ != &grid || stride_ != stride) {
    flush();
    begin(grid, stride);
  }
  const double place[3] = {ray.x * per_mm_[0], ray.y * per_mm_[1], ray.height * per_mm_[2]};
  const double from[3] = {ray.w.x, ray.w.y, ray.w.z};
  const int k = count_++;
  for (int a = 0; a < 3; ++a) {
    // Within the tile, and below its end in float as well.
    const double x = a < 2 ? wrapped(place[a], table_->voxels[a]) : place[a];
    place_[a][k] = static_cast<float>(std::min(std::max(x, 0.0), largest_[a]));
    speed_[a][k] = static_cast<float>(-from[a] * per_mm_[a]);
    from_[a][k] = static_cast<float>(from[a]);
  }
  const bool turned = table_->turned;
  const double sigma = turned ? table_->largest_sigma : lamella::sigma(grid.palette()[0], ray.w);
  scale_[k] = static_cast<float>(grid.layer_density() * (turned ? 1 : sigma));
  bound_[k] = static_cast<float>(grid.layer_density() * sigma * kMajorantMargin);
  names_[k] = static_cast<std::uint32_t>(StreamPurpose::shadow) | ordinal_++ << kPurposeBits;
  low_[k] = static_cast<std::uint32_t>(index_);
  high_[k] = static_cast<std::uint32_t>(index_ >> 32);
  worth_[k] = worth;
  sums_[k] = sums;
}

template <int C>
void ShadowQueue<C>::begin(const DensityGrid& grid, std::size_t stride) {
  grid_ = &grid;
  table_ = &tables_.of(grid);
  stride_ = stride;
  const Direction h = grid.voxel_size();
  per_mm_ = {1 / h.x, 1 / h.y, 1 / h.z};
  for (int a = 0; a < 3; ++a) largest_[a] = table_->voxels[a] * kBelowEnd;
}

template <int C>
void ShadowQueue<C>::flush() {
  if (count_ == 0) return;
  ShadowTask task;
  task.grid = lane_grid_of(*table_);
  for (int a = 0; a < 3; ++a) {
    task.place[a] = place_[a].data();
    task.speed[a] = speed_[a].data();
    task.from[a] = from_[a].data();
  }
  task.scale = scale_.data();
  task.bound = bound_.data();
  task.ordinal = names_.data();
  task.walk_low = low_.data();
  task.walk_high = high_.data();
  task.key_low = static_cast<std::uint32_t>(seed_);
  task.key_high = static_cast<std::uint32_t>(seed_ >> 32);
  task.count = count_;
  task.share = share_.data();
  switch (tables_.follow(task)) {
    case ShadowEnd::done:
      break;
    case ShadowEnd::majorant_too_low:
      throw MajorantError();
    case ShadowEnd::endless:
      throw EndlessRayError();
  }
  for (int k = 0; k < count_; ++k)
    for (int c = 0; c < C; ++c) sums_[k][c * stride_] += worth_[k][c] * share_[k];
  count_ = 0;
}

template class ShadowQueue<1>;
template class ShadowQueue<3>;

}  // namespace lamella
