#include "compare/preview/preview.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "compare/request/errors.h"

namespace lamella {
namespace {

constexpr int kRings = 12, kSpokes = 24;  // of the product rule over a hemisphere
constexpr int kMostTexels = 128, kUniformNodes = 64;
// The plane's camera stands at height 1 and looks down by this much; half its field of view.
constexpr double kPitch = 14 * kPi / 180, kHalfField = 20 * kPi / 180;
// Polar angle of the plane's lamp, which it is seen against.
constexpr double kLampBehindPlane = 70;

using Basis = Frame<double>;

// x to the right and y up, as far as they can be, in the plane with normal n.
Basis basis_around(Direction n) {
  const Direction up = std::abs(n.y) < 0.99 ? Direction{0, 1, 0} : Direction{1, 0, 0};
  const Direction x = normalized(cross(up, n));
  return {x, cross(n, x), n};
}

// Where a pixel's ray meets the scene.
struct Hit {
  Basis surface;
  Direction to_viewer;
};

std::optional<Hit> hit_of(const PreviewView& view, int column, int row) {
  const double x = (2 * column + 1.0) / view.width() - 1;
  const double y = (view.height() - (2 * row + 1.0)) / view.width();
  if (view.scene == PreviewScene::sphere) {
    const double margin = 1.04, r2 = margin * margin * (x * x + y * y);
    if (r2 >= 1) return std::nullopt;
    const Direction n{margin * x, margin * y, std::sqrt(1 - r2)};
    return Hit{basis_around(n), {0, 0, 1}};
  }
  const double field = std::tan(kHalfField);
  const Direction ray =
      normalized(Direction{field * x, -std::sin(kPitch) + field * y * std::cos(kPitch),
                           -std::cos(kPitch) - field * y * std::sin(kPitch)});
  if (ray.y > -1e-3) return std::nullopt;
  return Hit{{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}}, -1.0 * ray};
}

Direction lamp_of(const PreviewView& view) {
  if (view.scene == PreviewScene::plane) {
    const double theta = kLampBehindPlane * kPi / 180;
    return {0, std::cos(theta), -std::sin(theta)};
  }
  const double theta = view.lamp_theta * kPi / 180, phi = view.lamp_phi * kPi / 180;
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

// Integral over the hemisphere of f L mu_i: midpoints in mu_i^2 (equal projected solid angles) and
// in azimuth.
Rgb gathered(const Reflection& f, const Basis& surface, Direction wo, const Environment& from) {
  Rgb sum;
  for (int a = 0; a < kRings; ++a) {
    const double mu = std::sqrt((a + 0.5) / kRings);
    for (int b = 0; b < kSpokes; ++b) {
      const Direction wi = direction_from_mu_phi(mu, 2 * kPi * (b + 0.5) / kSpokes);
      const Rgb light = from.radiance(surface.to_world(wi)), value = f(wi, wo);
      for (int c = 0; c < 3; ++c) sum[c] += value[c] * light[c];
    }
  }
  return kPi / (kRings * kSpokes) * sum;
}

// Radiance under uniform light, which depends on mu_o alone: nodes at mu = (k / kUniformNodes)^2.
class UniformTable {
 public:
  UniformTable(const Reflection& f, const Environment& uniform) : values_(kUniformNodes + 1) {
    tbb::parallel_for(0, kUniformNodes + 1, [&](int k) {
      const double mu = std::max(k * k / static_cast<double>(kUniformNodes * kUniformNodes), 1e-3);
      const Direction wo = direction_from_mu_phi(mu, 0);
      values_[k] = gathered(f, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, wo, uniform);
    });
  }
  [[nodiscard]] Rgb operator()(double mu) const {
    const double x = std::sqrt(std::clamp(mu, 0.0, 1.0)) * kUniformNodes;
    const int k = std::min(static_cast<int>(x), kUniformNodes - 1);
    return (k + 1 - x) * values_[k] + (x - k) * values_[k + 1];
  }

 private:
  std::vector<Rgb> values_;
};

}  // namespace

Environment::Environment(const std::string& path) {
  const ExrImage image = read_exr(path);
  const auto channel = [&](const std::string& name) -> const std::vector<float>* {
    for (const auto& [n, values] : image.channels)
      if (n == name) return &values;
    return nullptr;
  };
  const std::vector<float>* rgb[3] = {channel("R"), channel("G"), channel("B")};
  if (!rgb[0] || !rgb[1] || !rgb[2])
    for (auto& c : rgb) c = channel("Y");
  if (!rgb[0])
    throw UsageError(fmt::format(
        "--environment {}: found no channels R, G, B; allowed: a lat-long EXR with them, or Y",
        path));
  width_ = std::min(image.width, kMostTexels);
  height_ = std::min(image.height, kMostTexels / 2);
  texels_.resize(static_cast<std::size_t>(width_) * height_);
  std::vector<int> count(texels_.size());
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const std::size_t from = static_cast<std::size_t>(y) * image.width + x;
      const Rgb value((*rgb[0])[from], (*rgb[1])[from], (*rgb[2])[from]);
      for (int c = 0; c < 3; ++c)
        if (!(value[c] >= 0 && std::isfinite(value[c])))
          throw UsageError(fmt::format(
              "--environment {}: found {} at x {}, y {}; allowed: finite numbers from 0", path,
              value[c], x, y));
      const std::size_t to =
          static_cast<std::size_t>(y * static_cast<long>(height_) / image.height) * width_ +
          static_cast<std::size_t>(x * static_cast<long>(width_) / image.width);
      texels_[to] += value;
      ++count[to];
    }
  for (std::size_t k = 0; k < texels_.size(); ++k) texels_[k] = (1.0 / count[k]) * texels_[k];
}

Rgb Environment::radiance(Direction world) const {
  if (is_uniform()) return Rgb(1);
  const double u = std::atan2(world.x, -world.z) / (2 * kPi) + 0.5;
  const double v = std::acos(std::clamp(world.y, -1.0, 1.0)) / kPi;
  const int x = std::clamp(static_cast<int>(u * width_), 0, width_ - 1);
  const int y = std::clamp(static_cast<int>(v * height_), 0, height_ - 1);
  return texels_[static_cast<std::size_t>(y) * width_ + x];
}

std::string to_text(PreviewScene scene) {
  return scene == PreviewScene::sphere ? "sphere" : "plane";
}

std::string to_text(PreviewLight light) {
  return light == PreviewLight::lamp ? "lamp" : "environment";
}

PreviewImage render(const Reflection& f, const PreviewView& view, const Environment& environment) {
  PreviewImage image{view.width(), view.height(), {}, {}};
  const auto pixels = static_cast<std::size_t>(image.width) * image.height;
  image.radiance.resize(pixels);
  std::vector<char> covered(pixels);
  std::optional<UniformTable> uniform;
  if (view.light == PreviewLight::environment && environment.is_uniform())
    uniform.emplace(f, environment);
  const Direction lamp = lamp_of(view);
  tbb::parallel_for(0, image.height, [&](int row) {
    for (int column = 0; column < image.width; ++column) {
      const auto hit = hit_of(view, column, row);
      if (!hit) continue;
      const std::size_t k = static_cast<std::size_t>(row) * image.width + column;
      covered[k] = 1;
      const Direction wo = hit->surface.to_local(hit->to_viewer);
      if (uniform) {
        image.radiance[k] = (*uniform)(wo.z);
      } else if (view.light == PreviewLight::environment) {
        image.radiance[k] = gathered(f, hit->surface, wo, environment);
      } else {
        const Direction wi = hit->surface.to_local(lamp);
        if (wi.z > 0) image.radiance[k] = kPi * wi.z * f(wi, wo);
      }
    }
  });
  image.covered.assign(covered.begin(), covered.end());
  return image;
}

}  // namespace lamella
