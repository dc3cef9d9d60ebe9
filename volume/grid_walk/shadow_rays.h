#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <vector>

#include "volume/grid_walk/shadow_task.h"
#include "volume/voxels/ray_table.h"

namespace lamella {

/// A ray from a place in a grid: x, y anywhere and the height above the lowest slice [mm]; w is
/// where the light comes from, as for ratio_tracked.
struct ShadowRay {
  double x, y, height;
  Direction w;
};

/// The density grids that a stack's next-event estimation sends shadow rays through on lanes.
class ShadowTables {
 public:
  /// No tables, and no lanes, for Isa::scalar or where any of the grids has none.
  ShadowTables(Isa isa, const std::vector<std::shared_ptr<const DensityGrid>>& grids);

  [[nodiscard]] bool on_lanes() const { return follow_ != nullptr; }
  /// Whether lanes take a ray: not too near to the horizon for places in float.
  [[nodiscard]] static bool takes(Direction w) { return std::abs(w.z) >= 1e-3; }
  [[nodiscard]] const GridRayTable& of(const DensityGrid& grid) const;
  [[nodiscard]] ShadowEnd follow(const ShadowTask& task) const { return follow_(task); }

 private:
  ShadowEnd (*follow_)(const ShadowTask&) = nullptr;
  std::vector<std::pair<const DensityGrid*, std::shared_ptr<const GridRayTable>>> tables_;
};

/// Shadow rays that wait until there are enough to fill lanes. What they are worth is added in the
/// order in which they came, and a ray's random numbers are named by its walk and its place among
/// the walk's rays: sums do not depend on when the rays are followed.
template <int C>
class ShadowQueue {
 public:
  ShadowQueue(const ShadowTables& tables, std::uint64_t seed) : tables_(tables), seed_(seed) {}

  void begin_walk(std::uint64_t index) {
    index_ = index;
    ordinal_ = 0;
  }
  /// Adds worth[c] times the share of the light that crosses the grid to sums[c stride].
  void push(const DensityGrid& grid, const ShadowRay& ray, const std::array<double, C>& worth,
            double* sums, std::size_t stride);
  /// Follows all that wait. Throws as ratio_tracked.
  void flush();

 private:
  using Floats = std::array<float, kShadowRays>;
  using Words = std::array<std::uint32_t, kShadowRays>;

  // The rays that wait from here on.
  void begin(const DensityGrid& grid, std::size_t stride);

  const ShadowTables& tables_;
  std::uint64_t seed_, index_ = 0;
  std::uint32_t ordinal_ = 0;
  const DensityGrid* grid_ = nullptr;  // of those that wait
  const GridRayTable* table_ = nullptr;
  std::size_t stride_ = 0;
  std::array<double, 3> per_mm_{}, largest_{};  // voxels; the last place in float
  int count_ = 0;
  std::array<Floats, 3> place_{}, speed_{}, from_{};
  Floats scale_{}, bound_{}, share_{};
  Words names_{}, low_{}, high_{};
  std::array<std::array<double, C>, kShadowRays> worth_{};
  std::array<double*, kShadowRays> sums_{};
};

}  // namespace lamella
