#include "volume/mesh/triangle_mesh.h"

#include <algorithm>
#include <cmath>

#include "phase/math/direction.h"

namespace lamella {

TriangleMesh draped_cloth() {
  constexpr double kHalfWidth = 2.1, kTouch = 0.9, kFall = 2.6, kFolds = 8;
  const auto smooth = [](double x) {
    const double t = std::clamp(x, 0.0, 1.0);
    return t * t * (3 - 2 * t);
  };
  return patch(256, 256, [&](double u, double v) {
    const double x = kHalfWidth * (2 * u - 1), z = kHalfWidth * (1 - 2 * v);
    // Length along the cloth from the top of the ball.
    const double s = std::sqrt(x * x + z * z), azimuth = std::atan2(z, x);
    const double angle = std::min(s, kTouch);
    double r = std::sin(angle), y = std::cos(angle);
    if (s > kTouch) {
      // From the tangent of the ball, the cloth turns down until it hangs.
      const double along = s - kTouch, turn = smooth(along / kFall);
      const double slope = kTouch + (kPi / 2 - 0.12 - kTouch) * std::min(1.0, 2 * turn);
      r += along * std::cos((kTouch + slope) / 2);
      y -= along * std::sin((kTouch + slope) / 2);
    }
    const double fold = 0.22 * smooth((s - kTouch) / 1.8);
    const double wave = std::cos(kFolds * azimuth + 0.6 * std::sin(3 * azimuth));
    const double out = s > 0 ? (r + fold * wave) / s : 1;
    return Direction{out * x, y + 0.25 * fold * wave, out * z};
  });
}

TriangleMesh trefoil_knot() {
  constexpr double kTube = 0.32, kScale = 0.36;
  const auto curve = [](double t) {
    return kScale * Direction{std::sin(t) + 2 * std::sin(2 * t), std::cos(t) - 2 * std::cos(2 * t),
                              -1.4 * std::sin(3 * t)};
  };
  return patch(512, 96, [&](double u, double v) {
    const double t = 2 * kPi * u, turn = 2 * kPi * v;
    const Direction centre = curve(t);
    const Direction along = normalized(curve(t + 1e-4) - curve(t - 1e-4));
    // A frame that closes after one round: the plane's normal, made perpendicular to the curve.
    const Direction up{0, 0, 1};
    const Direction across = normalized(up - dot(up, along) * along);
    const Direction third = cross(along, across);
    return centre + kTube * (std::cos(turn) * across + std::sin(turn) * third);
  });
}

}  // namespace lamella
