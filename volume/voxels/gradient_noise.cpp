#include "volume/voxels/gradient_noise.h"

#include <cmath>

#include "phase/math/sampling.h"
#include "phase/random/random.h"

namespace lamella {
namespace {

double fade(double t) { return t * t * t * (t * (6 * t - 15) + 10); }

int wrapped(int i, int n) { return ((i % n) + n) % n; }

}  // namespace

GradientNoise::GradientNoise(std::array<int, 3> cells, std::uint64_t seed) : cells_(cells) {
  RandomStream stream(seed, 0, StreamPurpose::model);
  gradients_.resize(static_cast<std::size_t>(cells[0]) * cells[1] * cells[2]);
  for (auto& g : gradients_) {
    const double u1 = stream.uniform(), u2 = stream.uniform();
    const Direction d = uniform_sphere(u1, u2);
    g = {d.x, d.y, d.z};
  }
}

double GradientNoise::operator()(double x, double y, double z) const {
  const double place[3] = {x, y, z};
  int base[3];
  double t[3];
  for (int a = 0; a < 3; ++a) {
    base[a] = static_cast<int>(std::floor(place[a]));
    t[a] = place[a] - base[a];
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    int i[3];
    double weight = 1, slope[3];
    for (int a = 0; a < 3; ++a) {
      const int far = (corner >> a) & 1;
      i[a] = wrapped(base[a] + far, cells_[a]);
      slope[a] = t[a] - far;
      weight *= far ? fade(t[a]) : 1 - fade(t[a]);
    }
    const auto& g =
        gradients_[(static_cast<std::size_t>(i[2]) * cells_[1] + i[1]) * cells_[0] + i[0]];
    sum += weight * (g[0] * slope[0] + g[1] * slope[1] + g[2] * slope[2]);
  }
  // A single corner's slope reaches sqrt(3) / 2 where all eight weigh the same.
  return sum * 2 / std::sqrt(3.0);
}

}  // namespace lamella
