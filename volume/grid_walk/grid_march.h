#pragma once

#include <cmath>
#include <limits>

#include "phase/random/random.h"
#include "volume/voxels/density_grid.h"

namespace lamella {

/// x modulo the period n, in [0, n] up to rounding. Nearly always there already.
[[nodiscard]] inline double wrapped(double x, int n) {
  return x >= 0 && x <= n ? x : x - n * std::floor(x / n);
}

/// A straight way through a density grid, one cell of constant majorant after another: a digital
/// differential analyser whose cells are as large as their content allows, so that empty space is
/// crossed in few steps. Lengths in mm from the start. The grid repeats in x and y.
class GridMarch {
 public:
  /// x, y: any [mm]; height above the grid's lowest slice [mm], in [0, thickness]; d: unit, where
  /// the way leads.
  GridMarch(const DensityGrid& grid, double x, double y, double height, Direction d) : grid_(grid) {
    const VoxelIndex n = grid.extent().voxels;
    const Direction h = grid.voxel_size();
    const double place[3] = {x / h.x, y / h.y, height / h.z};
    rate_[0] = d.x / h.x;
    rate_[1] = d.y / h.y;
    rate_[2] = d.z / h.z;
    for (int a = 0; a < 3; ++a) {
      inverse_[a] = rate_[a] != 0 ? 1 / rate_[a] : std::numeric_limits<double>::infinity();
      place_[a] = a < 2 ? wrapped(place[a], n[a]) : place[a];
      voxel_[a] = std::min(std::max(static_cast<int>(place_[a]), 0), n[a] - 1);
    }
    enter();
  }

  /// The cell that the way is in, and the length of its way there.
  [[nodiscard]] const MajorantCell& cell() const { return *cell_; }
  [[nodiscard]] double length() const { return length_; }
  /// Any voxel of the cell, as its name.
  [[nodiscard]] VoxelIndex somewhere() const { return voxel_; }
  /// Length of the way before the cell.
  [[nodiscard]] double before() const { return before_; }

  /// The voxel that lies `s` further on in the cell, 0 <= s <= length().
  [[nodiscard]] VoxelIndex voxel(double s) const {
    VoxelIndex i;
    for (int a = 0; a < 3; ++a) {
      double x = place_[a] + s * rate_[a];
      if (spans_[a]) x = wrapped(x, high_[a]);
      i[a] = std::min(std::max(static_cast<int>(x), low_[a]), high_[a] - 1);
    }
    return i;
  }

  /// On to the next cell; false if the way leaves the grid above or below (or never ends: a level
  /// way along a cell as wide as the tile).
  bool next() {
    if (exit_axis_ < 0) return false;
    const VoxelIndex n = grid_.extent().voxels;
    for (int a = 0; a < 3; ++a) {
      if (a == exit_axis_) continue;
      place_[a] += length_ * rate_[a];
      if (spans_[a]) place_[a] = wrapped(place_[a], n[a]);
      voxel_[a] = std::min(std::max(static_cast<int>(place_[a]), low_[a]), high_[a] - 1);
    }
    const int a = exit_axis_;
    const bool up = rate_[a] > 0;
    int i = up ? high_[a] : low_[a] - 1;
    if (i < 0 || i >= n[a]) {
      if (a == 2) return false;
      i = up ? 0 : n[a] - 1;
      place_[a] = up ? 0 : n[a];
    } else {
      place_[a] = up ? high_[a] : low_[a];
    }
    voxel_[a] = i;
    before_ += length_;
    enter();
    return true;
  }

 private:
  void enter() {
    cell_ = &grid_.cell(voxel_);
    const VoxelIndex n = grid_.extent().voxels;
    const int mask = (kBlockVoxels << cell_->level) - 1;
    length_ = std::numeric_limits<double>::infinity();
    exit_axis_ = -1;
    for (int a = 0; a < 3; ++a) {
      low_[a] = voxel_[a] & ~mask;
      high_[a] = std::min(low_[a] + mask + 1, n[a]);
      spans_[a] = a < 2 && low_[a] == 0 && high_[a] == n[a];
      if (spans_[a] || rate_[a] == 0) continue;
      const double to = ((rate_[a] > 0 ? high_[a] : low_[a]) - place_[a]) * inverse_[a];
      if (to < length_) {
        length_ = to;
        exit_axis_ = a;
      }
    }
    if (!(length_ > 0)) length_ = 0;
  }

  const DensityGrid& grid_;
  const MajorantCell* cell_ = nullptr;
  double rate_[3], inverse_[3];  // voxels per mm, mm per voxel
  double place_[3];              // in voxels
  VoxelIndex voxel_, low_{}, high_{};
  bool spans_[3]{};  // the cell is as wide as the tile: no sides there
  int exit_axis_ = -1;
  double length_ = 0, before_ = 0;
};

/// Cells that one way may cross before it counts as endless: a level one along empty rows.
inline constexpr std::uint64_t kMostCells = std::uint64_t{1} << 27;

enum class Flight { collided, left, endless };

struct GridFlight {
  Flight end = Flight::left;
  double length = 0;   ///< of the way [mm], to the collision or out of the grid
  VoxelIndex voxel{};  ///< where it collided
};

/// A voxel met more extinction than its cell's majorant: a defect.
struct MajorantError : std::runtime_error {
  MajorantError() : std::runtime_error("a density grid's majorant is below its content") {}
};

/// A shadow ray had no end within what is followed.
struct EndlessRayError : std::runtime_error {
  EndlessRayError()
      : std::runtime_error(
            "a shadow ray crossed 2^27 cells of a density grid without an end; allowed: directions "
            "farther from the horizon") {}
};

/// The tentative collisions of a way through a grid, by delta tracking: each cell's majorant
/// proposes them, extinction over majorant is the probability of a real one. M: the kind of medium.
template <class M>
class TentativeCollisions {
 public:
  enum class Next { tentative, left, endless };

  /// From a point of the grid; w: where the light comes from, -d.
  TentativeCollisions(const DensityGrid& grid, double x, double y, double height, Direction w)
      : grid_(grid),
        march_(grid, x, y, height, -w),
        w_(w),
        local_(grid.is_local()),
        sigma_(local_ ? 0 : std::get_if<M>(&grid.palette()[0])->sigma(w)) {
    enter();
  }

  /// Goes on to the next tentative collision, or out of the grid. `remaining`: the exponential
  /// number that is left of the flight; the rest after the way stays for the layer beyond.
  [[nodiscard]] Next next(double& remaining) {
    for (;;) {
      if (majorant_ > 0) {
        const double end = march_.length(), to = at_ + remaining / majorant_;
        if (to < end) {
          at_ = to;
          voxel_ = march_.voxel(at_);
          const double rho = grid_.density(voxel_);
          extinction_ = grid_.layer_density() * rho *
                        (local_ && rho > 0 ? grid_.template sigma<M>(voxel_, w_) : sigma_);
          if (extinction_ > majorant_ * (1 + 1e-9)) throw MajorantError();
          return Next::tentative;
        }
        remaining -= majorant_ * (end - at_);
        if (!(remaining > 0)) remaining = 1e-300;  // rounding; the next cell decides at once
      }
      if (!march_.next()) {
        at_ = march_.length();
        return std::isfinite(at_) ? Next::left : Next::endless;
      }
      enter();
      if (++cells_ == kMostCells) return Next::endless;
    }
  }

  /// Of the tentative collision: extinction and majorant [1/mm], the voxel.
  [[nodiscard]] double extinction() const { return extinction_; }
  [[nodiscard]] double majorant() const { return majorant_; }
  [[nodiscard]] VoxelIndex voxel() const { return voxel_; }
  /// Of the way so far [mm].
  [[nodiscard]] double length() const { return march_.before() + at_; }

 private:
  void enter() {
    const MajorantCell& cell = march_.cell();
    const double area = local_ && cell.density > 0
                            ? grid_.template sigma_bound<M>(march_.somewhere(), cell, w_)
                            : sigma_;
    majorant_ = grid_.layer_density() * cell.density * area;
    at_ = 0;
  }

  const DensityGrid& grid_;
  GridMarch march_;
  Direction w_;
  bool local_;
  double sigma_;  // where the medium does not vary
  double majorant_ = 0, at_ = 0, extinction_ = 0;
  VoxelIndex voxel_{};
  std::uint64_t cells_ = 0;
};

/// Free flight from a point of the grid. `remaining` is the exponential number that is left of the
/// flight; when the way leaves the grid, the rest stays for the layer beyond.
template <class M>
[[nodiscard]] GridFlight fly(const DensityGrid& grid, double x, double y, double height,
                             Direction w, double& remaining, RandomStream& stream) {
  using Collisions = TentativeCollisions<M>;
  Collisions way(grid, x, y, height, w);
  for (;;) {
    const auto next = way.next(remaining);
    if (next != Collisions::Next::tentative)
      return {next == Collisions::Next::left ? Flight::left : Flight::endless, way.length(), {}};
    if (way.extinction() >= way.majorant() || stream.uniform() * way.majorant() < way.extinction())
      return {Flight::collided, way.length(), way.voxel()};
    remaining = stream.exponential();
  }
}

/// The same flight voxel by voxel: where it ends is a continuous function of `remaining` and of the
/// place, as quasi-Monte Carlo needs it, at the price of the voxels on the way.
template <class M>
[[nodiscard]] GridFlight fly_by_voxels(const DensityGrid& grid, double x, double y, double height,
                                       Direction w, double& remaining) {
  const bool local = grid.is_local();
  const double sigma = local ? 0 : std::get_if<M>(&grid.palette()[0])->sigma(w);
  const VoxelIndex n = grid.extent().voxels;
  const Direction h = grid.voxel_size();
  const double start[3] = {wrapped(x / h.x, n[0]), wrapped(y / h.y, n[1]), height / h.z};
  const double rate[3] = {-w.x / h.x, -w.y / h.y, -w.z / h.z};
  VoxelIndex i{};
  int step[3];
  double next[3], apart[3];  // the way to the next side, and between two of them [mm]
  for (int a = 0; a < 3; ++a) {
    i[a] = std::min(std::max(static_cast<int>(start[a]), 0), n[a] - 1);
    step[a] = rate[a] > 0 ? 1 : -1;
    apart[a] = rate[a] != 0 ? std::abs(1 / rate[a]) : std::numeric_limits<double>::infinity();
    next[a] = rate[a] != 0 ? std::max(0.0, (i[a] + (rate[a] > 0) - start[a]) / rate[a]) : apart[a];
  }
  double way = 0;
  for (std::uint64_t count = 0; count < kMostCells; ++count) {
    const int a = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
    const double rho = grid.density(i);
    if (rho > 0) {
      const double extinction =
          grid.layer_density() * rho * (local ? grid.template sigma<M>(i, w) : sigma);
      const double depth = extinction * (next[a] - way);
      if (remaining < depth) return {Flight::collided, way + remaining / extinction, i};
      remaining = std::max(remaining - depth, 1e-300);
    }
    way = next[a];
    next[a] += apart[a];
    i[a] += step[a];
    if (i[a] < 0 || i[a] >= n[a]) {
      if (a == 2) return {Flight::left, way, {}};
      i[a] = i[a] < 0 ? n[a] - 1 : 0;
    }
  }
  return {Flight::endless, way, {}};
}

/// An unbiased estimate of the share of light from w that crosses the grid from a point in it to
/// its top or bottom, by ratio tracking (Novak et al. 2014, "Residual ratio tracking for estimating
/// attenuation in participating media"); once the product is small, Russian roulette decides
/// whether the estimate continues.
template <class M>
[[nodiscard]] double ratio_tracked(const DensityGrid& grid, double x, double y, double height,
                                   Direction w, RandomStream& stream) {
  constexpr double kLittle = 0.1, kChance = 0.25;
  using Collisions = TentativeCollisions<M>;
  Collisions way(grid, x, y, height, w);
  double share = 1, remaining = stream.exponential(), little = kLittle;
  for (;;) {
    const auto next = way.next(remaining);
    if (next == Collisions::Next::left || std::isinf(way.length())) return share;
    if (next == Collisions::Next::endless) break;
    share *= 1 - way.extinction() / way.majorant();
    if (!(share > 0)) return 0;
    if (share < little) {
      if (stream.uniform() >= kChance) return 0;
      share /= kChance;
      little *= kLittle;
    }
    remaining = stream.exponential();
  }
  throw EndlessRayError();
}

}  // namespace lamella
