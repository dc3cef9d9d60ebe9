#include "volume/grains/height_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "phase/math/direction.h"
#include "phase/random/random.h"

namespace lamella {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<double> white_noise(std::size_t count, RandomStream& stream) {
  std::vector<double> noise(count + count % 2);
  for (std::size_t k = 0; k < noise.size(); k += 2) {
    const double radius = std::sqrt(2 * stream.exponential()), angle = 2 * kPi * stream.uniform();
    noise[k] = radius * std::cos(angle);
    noise[k + 1] = radius * std::sin(angle);
  }
  noise.resize(count);
  return noise;
}

// A Gaussian whose autocorrelation is exp(-r^2 / length^2), r in steps, down to double's rounding.
std::vector<double> smoothing(double length) {
  const int reach = static_cast<int>(std::ceil(4.3 * length));
  std::vector<double> kernel(2 * reach + 1);
  for (int k = -reach; k <= reach; ++k) {
    const double r = k / length;
    kernel[k + reach] = std::exp(-2 * r * r);
  }
  return kernel;
}

// Along rows of an n x n field that repeats; columns of the result are those rows.
std::vector<double> smoothed(const std::vector<double>& field, int n,
                             const std::vector<double>& kernel) {
  const int reach = static_cast<int>(kernel.size()) / 2;
  std::vector<double> line(n + 2 * reach), result(field.size());
  for (int j = 0; j < n; ++j) {
    for (int i = -reach; i < n + reach; ++i)
      line[i + reach] = field[static_cast<std::size_t>(j) * n + ((i % n) + n) % n];
    for (int i = 0; i < n; ++i) {
      double sum = 0;
      for (std::size_t k = 0; k < kernel.size(); ++k) sum += kernel[k] * line[i + k];
      result[static_cast<std::size_t>(i) * n + j] = sum;
    }
  }
  return result;
}

}  // namespace

HeightField::HeightField(const GrainGeometry& g, std::uint64_t seed, std::uint64_t realisation)
    : nodes_(g.nodes), tile_(g.tile), step_(g.tile / g.nodes) {
  RandomStream stream(seed, realisation, StreamPurpose::geometry);
  const std::vector<double> kernel = smoothing(g.radius / step_);
  heights_ = white_noise(static_cast<std::size_t>(nodes_) * nodes_, stream);
  for (int axis = 0; axis < 2; ++axis) heights_ = smoothed(heights_, nodes_, kernel);
  // Slopes of the triangles' sides have the variance alpha^2 / 2 of Beckmann's.
  double square = 0, differences = 0;
  for (std::size_t k = 0; k <= kernel.size(); ++k) {
    const double here = k < kernel.size() ? kernel[k] : 0, before = k > 0 ? kernel[k - 1] : 0;
    square += here * here;
    differences += (here - before) * (here - before);
  }
  const double scale = g.alpha * step_ / std::sqrt(2 * square * differences);
  for (double& h : heights_) h *= scale;
  const auto [low, high] = std::minmax_element(heights_.begin(), heights_.end());
  lowest_ = *low;
  highest_ = *high;
}

GrainHit HeightField::trace(Direction o, Direction d) const {
  if (o.z > highest_) {
    if (!(d.z < 0)) return {.end = RayEnd::up};
    o = o + ((o.z - highest_) / -d.z) * d;
    o.z = highest_;
  }
  const double leaves = d.z > 0 ? (highest_ - o.z) / d.z : kInfinity;
  auto i = static_cast<std::int64_t>(std::floor(o.x / step_));
  auto j = static_cast<std::int64_t>(std::floor(o.y / step_));
  const std::int64_t most = static_cast<std::int64_t>(kMostTiles) * nodes_;
  double t = 0;
  for (std::int64_t squares = 0; squares < most; ++squares) {
    const auto until = [&](double at, double along, std::int64_t k) {
      return along > 0   ? (static_cast<double>(k + 1) * step_ - at) / along
             : along < 0 ? (static_cast<double>(k) * step_ - at) / along
                         : kInfinity;
    };
    const double tx = until(o.x, d.x, i), ty = until(o.y, d.y, j);
    const double end = std::max(t, std::min({tx, ty, leaves, kInfinity}));
    const double h00 = height(i, j), h10 = height(i + 1, j), h01 = height(i, j + 1),
                 h11 = height(i + 1, j + 1);
    // The squares' diagonal, u + v = 1 with u and v from 0 to 1, between the two triangles.
    const double u = o.x / step_ - static_cast<double>(i), v = o.y / step_ - static_cast<double>(j);
    const double speed = (d.x + d.y) / step_;
    const double diagonal = speed != 0 ? (1 - u - v) / speed : kInfinity;
    const bool crosses = diagonal > t && diagonal < end;
    for (int piece = 0; piece < (crosses ? 2 : 1); ++piece) {
      const double from = piece == 0 ? t : diagonal;
      const double to = crosses && piece == 0 ? diagonal : std::min(end, 1e300);
      const double middle = std::isfinite(to) ? (from + to) / 2 : from;
      const bool lower = crosses ? (speed > 0) == (piece == 0) : u + v + speed * middle < 1;
      const double gx = (lower ? h10 - h00 : h11 - h01) / step_;
      const double gy = (lower ? h01 - h00 : h11 - h10) / step_;
      const double climb = d.z - gx * d.x - gy * d.y;  // away from the surface
      if (climb >= 0 || !(to > from)) continue;
      const double base =
          lower ? h00 + step_ * (gx * u + gy * v) : h11 - step_ * (gx * (1 - u) + gy * (1 - v));
      const double above = o.z - base;  // of the ray at its origin over the triangle's plane
      const double hit = std::max(from, above / -climb);
      if (hit > to) continue;
      Direction p = o + hit * d;
      p.z = base + hit * (gx * d.x + gy * d.y);
      p.x -= tile_ * std::floor(p.x / tile_);
      p.y -= tile_ * std::floor(p.y / tile_);
      return {.end = RayEnd::grain, .point = p, .normal = normalized(Direction{-gx, -gy, 1})};
    }
    if (leaves <= end) return {.end = RayEnd::up};
    if (!std::isfinite(end)) break;  // straight down, and beside the square by rounding
    if (tx <= ty) i += d.x > 0 ? 1 : -1;
    if (ty <= tx) j += d.y > 0 ? 1 : -1;
    t = end;
  }
  return {.end = RayEnd::lost};
}

}  // namespace lamella
