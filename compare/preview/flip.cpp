#include "compare/preview/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "phase/math/direction.h"

namespace lamella {
namespace {

using Plane = std::vector<double>;
// Three numbers per pixel, in whichever space.
using Triple = std::array<double, 3>;

// Linear sRGB to CIE XYZ (IEC 61966-2-1), over the XYZ of white: white is (1, 1, 1).
constexpr double kToXyz[3][3] = {
    {10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794},
    {2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897},
    {1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382}};

Triple xyz_over_white(const Triple& rgb) {
  Triple out{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double* row = kToXyz[k];
    out[k] = (row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2]) / (row[0] + row[1] + row[2]);
  }
  return out;
}

// The inverse, by Cramer's rule on the scaled rows.
Triple rgb_from(const Triple& xyz) {
  double m[3][3];
  for (int k = 0; k < 3; ++k)
    for (int c = 0; c < 3; ++c)
      m[k][c] = kToXyz[k][c] / (kToXyz[k][0] + kToXyz[k][1] + kToXyz[k][2]);
  const auto det = [](const double a[3][3]) {
    return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
           a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
           a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
  };
  const double all = det(m);
  Triple out{};
  for (int c = 0; c < 3; ++c) {
    double with[3][3];
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j) with[k][j] = j == c ? xyz[k] : m[k][j];
    out[c] = det(with) / all;
  }
  return out;
}

// YCxCz: CIELAB without its cube root, in which light adds up.
Triple opponent(const Triple& rgb) {
  const Triple xyz = xyz_over_white(rgb);
  return {116 * xyz[1] - 16, 500 * (xyz[0] - xyz[1]), 200 * (xyz[1] - xyz[2])};
}
Triple rgb_from_opponent(const Triple& v) {
  const double y = (v[0] + 16) / 116;
  return rgb_from({y + v[1] / 500, y, y - v[2] / 200});
}

// CIELAB whose a and b fade in the dark (Hunt's effect), a' = 0.01 L a.
Triple hunt_lab(const Triple& rgb) {
  const auto root = [](double t) {
    constexpr double kDelta = 6.0 / 29;
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
  };
  const Triple xyz = xyz_over_white(rgb);
  const double y = root(xyz[1]), l = 116 * y - 16;
  return {l, 0.01 * l * 500 * (root(xyz[0]) - y), 0.01 * l * 200 * (y - root(xyz[2]))};
}

// HyAB: city blocks in lightness, Euclidean in a and b.
double hyab(const Triple& a, const Triple& b) {
  return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

// One-dimensional kernels of 2 radius + 1 weights.
using Kernel = std::vector<double>;

Kernel kernel_of(int radius, const auto& weight) {
  Kernel kernel;
  for (int x = -radius; x <= radius; ++x) kernel.push_back(weight(x));
  return kernel;
}

// Positive and negative weights sum to 1 and -1 each.
Kernel normalised(Kernel kernel) {
  double positive = 0, negative = 0;
  for (const double w : kernel) (w > 0 ? positive : negative) += std::abs(w);
  for (double& w : kernel) w /= w > 0 ? positive : negative;
  return kernel;
}

// Along x with one kernel, then along y with another.
Plane convolved(const Plane& plane, int width, int height, const Kernel& along_x,
                const Kernel& along_y) {
  const auto pass = [&](const Plane& in, const Kernel& kernel, bool rows) {
    const int radius = static_cast<int>(kernel.size() / 2);
    Plane out(in.size());
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        double sum = 0;
        for (int k = -radius; k <= radius; ++k) {
          const int at_x = rows ? std::clamp(x + k, 0, width - 1) : x;
          const int at_y = rows ? y : std::clamp(y + k, 0, height - 1);
          sum += kernel[static_cast<std::size_t>(k + radius)] *
                 in[static_cast<std::size_t>(at_y) * static_cast<std::size_t>(width) +
                    static_cast<std::size_t>(at_x)];
        }
        out[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
            static_cast<std::size_t>(x)] = sum;
      }
    return out;
  };
  return pass(pass(plane, along_x, true), along_y, false);
}

// The contrast sensitivity of a channel as a sum of two Gaussians over the angle x [degrees]:
// a sqrt(pi / b) exp(-pi^2 x^2 / b). The constants are the paper's.
struct Sensitivity {
  double a[2], b[2];
};
constexpr Sensitivity kSensitivities[] = {
    {{1, 0}, {0.0047, 1e-5}}, {{1, 0}, {0.0053, 1e-5}}, {{34.1, 13.5}, {0.04, 0.025}}};
constexpr double kWidest = 0.04;

Plane blurred(const Plane& plane, int width, int height, const Sensitivity& s,
              double pixels_per_degree) {
  const int radius =
      static_cast<int>(std::ceil(3 * std::sqrt(kWidest / (2 * kPi * kPi)) * pixels_per_degree));
  Plane out(plane.size());
  double weights = 0;
  for (int k = 0; k < 2; ++k) {
    if (s.a[k] == 0) continue;
    const Kernel kernel = kernel_of(radius, [&](int x) {
      const double degrees = x / pixels_per_degree;
      return std::exp(-kPi * kPi * degrees * degrees / s.b[k]);
    });
    double sum = 0;
    for (const double w : kernel) sum += w;
    const double scale = s.a[k] * std::sqrt(kPi / s.b[k]);
    const Plane part = convolved(plane, width, height, kernel, kernel);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += scale * part[i];
    weights += scale * sum * sum;
  }
  for (double& v : out) v /= weights;
  return out;
}

// Colours as the eye resolves them, in adjusted CIELAB.
std::vector<Triple> seen_colors(const std::vector<Triple>& opponents, int width, int height,
                                double pixels_per_degree) {
  std::vector<Triple> out(opponents.size());
  for (std::size_t c = 0; c < 3; ++c) {
    Plane plane;
    for (const Triple& v : opponents) plane.push_back(v[c]);
    plane = blurred(plane, width, height, kSensitivities[c], pixels_per_degree);
    for (std::size_t k = 0; k < out.size(); ++k) out[k][c] = plane[k];
  }
  for (Triple& v : out) {
    v = rgb_from_opponent(v);
    for (double& x : v) x = std::clamp(x, 0.0, 1.0);
    v = hunt_lab(v);
  }
  return out;
}

// Lengths of the gradients (edges) and of the second derivatives (points) of the lightness.
struct Features {
  Plane edges, points;
};

Features features_of(const std::vector<Triple>& opponents, int width, int height,
                     double pixels_per_degree) {
  constexpr double kFeatureWidth = 0.082;  // degrees
  const double deviation = 0.5 * kFeatureWidth * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3 * deviation));
  const auto gaussian = [&](int x) { return std::exp(-x * x / (2 * deviation * deviation)); };
  const Kernel smooth = normalised(kernel_of(radius, gaussian));
  const Kernel edge = normalised(kernel_of(radius, [&](int x) { return -x * gaussian(x); }));
  const Kernel point = normalised(kernel_of(
      radius, [&](int x) { return (x * x / (deviation * deviation) - 1) * gaussian(x); }));
  Plane lightness;
  for (const Triple& v : opponents) lightness.push_back((v[0] + 16) / 116);
  const auto lengths = [&](const Kernel& kernel) {
    Plane x = convolved(lightness, width, height, kernel, smooth);
    const Plane y = convolved(lightness, width, height, smooth, kernel);
    for (std::size_t k = 0; k < x.size(); ++k) x[k] = std::hypot(x[k], y[k]);
    return x;
  };
  return {lengths(edge), lengths(point)};
}

// The exponents of colour and features, and where the colour's error is compressed: a share of the
// largest one gets most of the range.
constexpr double kColorPower = 0.7, kFeaturePower = 0.5, kKnee = 0.4, kKneeError = 0.95;

double color_error(double distance) {
  static const double most = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), kColorPower);
  const double d = std::pow(distance, kColorPower), knee = kKnee * most;
  if (d < knee) return kKneeError / knee * d;
  return std::min(1.0, kKneeError + (d - knee) / (most - knee) * (1 - kKneeError));
}

std::vector<Triple> opponents_of(std::span<const Rgb> picture) {
  std::vector<Triple> out;
  for (const Rgb& v : picture)
    out.push_back(opponent(
        {std::clamp(v.r, 0.0, 1.0), std::clamp(v.g, 0.0, 1.0), std::clamp(v.b, 0.0, 1.0)}));
  return out;
}

}  // namespace

std::vector<double> flip_errors(int width, int height, std::span<const Rgb> reference,
                                std::span<const Rgb> test, double pixels_per_degree) {
  const std::vector<Triple> a = opponents_of(reference), b = opponents_of(test);
  const auto colors_a = seen_colors(a, width, height, pixels_per_degree);
  const auto colors_b = seen_colors(b, width, height, pixels_per_degree);
  const Features features_a = features_of(a, width, height, pixels_per_degree);
  const Features features_b = features_of(b, width, height, pixels_per_degree);
  std::vector<double> errors(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    const double feature = std::max(std::abs(features_a.edges[k] - features_b.edges[k]),
                                    std::abs(features_a.points[k] - features_b.points[k]));
    const double raised = std::pow(std::min(1.0, feature / std::sqrt(2.0)), kFeaturePower);
    const double color = color_error(hyab(colors_a[k], colors_b[k]));
    errors[k] = color > 0 ? std::pow(color, 1 - raised) : 0;
  }
  return errors;
}

}  // namespace lamella
