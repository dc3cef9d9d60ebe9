#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "phase/math/direction.h"

// What the textbook loops share: a generator, and directions in a frame.
namespace lamella::textbook {

/// O'Neill 2014; one stream for all walks.
struct Pcg32 {
  std::uint64_t state, increment;

  std::uint32_t bits() {
    const std::uint64_t old = state;
    state = old * 6364136223846793005ULL + increment;
    const auto xorshifted = static_cast<std::uint32_t>(((old >> 18) ^ old) >> 27);
    const auto rotation = static_cast<std::uint32_t>(old >> 59);
    return (xorshifted >> rotation) | (xorshifted << ((32 - rotation) & 31));
  }
  double uniform() { return (bits() + 0.5) * 0x1p-32; }
  void begin_walk(std::uint64_t) {}
};

/// The direction with the given local coordinates in a frame about n (Duff et al. 2017).
inline Direction from_frame(Direction n, double x, double y, double z) {
  const double sign = std::copysign(1.0, n.z);
  const double a = -1 / (sign + n.z);
  const double b = n.x * n.y * a;
  const Direction s{1 + sign * n.x * n.x * a, sign * b, -sign * n.x};
  const Direction t{b, sign + n.y * n.y * a, -n.y};
  return x * s + y * t + z * n;
}

inline Direction around(Direction axis, double cosine, double u) {
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  const double phi = 2 * kPi * u;
  return from_frame(axis, sine * std::cos(phi), sine * std::sin(phi), cosine);
}

inline Direction mirrored_at(Direction m, Direction wi) {
  return normalized(2 * dot(wi, m) * m - wi);
}

/// Lambert's law about n.
inline Direction cosine_law(Direction n, auto& rng) {
  const double r = std::sqrt(rng.uniform()), phi = 2 * kPi * rng.uniform();
  return normalized(
      from_frame(n, r * std::cos(phi), r * std::sin(phi), std::sqrt(std::max(0.0, 1 - r * r))));
}
inline double cosine_law_density(Direction n, Direction wo) {
  return std::max(0.0, dot(n, wo)) / kPi;
}

/// d'Eon 2021, eq. 6: away from a Lambertian sphere.
inline Direction from_lambert_sphere(Direction wi, auto& rng) {
  const double u1 = rng.uniform(), u2 = rng.uniform(), u3 = rng.uniform();
  const double cosine =
      std::sqrt((1 - u1) * (1 - u2)) * std::sin(2 * kPi * u3) - std::sqrt(u1 * u2);
  return around(-wi, cosine, rng.uniform());
}

/// The cells that leaving light is counted in.
inline constexpr int kMuCells = 16, kPhiCells = 32;
inline constexpr double kCellsPerSteradian = kMuCells * kPhiCells / kPi;
/// The cell that light leaves to, w_i pointing back along its way.
inline int cell_of(Direction wi) {
  double phi = std::atan2(-wi.y, -wi.x);
  if (phi < 0) phi += 2 * kPi;
  const int row = std::min(static_cast<int>((1 - wi.z * wi.z) * kMuCells), kMuCells - 1);
  const int column = std::min(static_cast<int>(phi / (2 * kPi) * kPhiCells), kPhiCells - 1);
  return row * kPhiCells + column;
}

}  // namespace lamella::textbook
