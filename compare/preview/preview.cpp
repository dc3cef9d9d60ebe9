#include "compare/preview/preview.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace lamella {
namespace {

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

}  // namespace

std::string to_text(PreviewScene scene) {
  return scene == PreviewScene::sphere ? "sphere" : "plane";
}

std::string to_text(PreviewLight light) {
  return light == PreviewLight::lamp ? "lamp" : "environment";
}

namespace {

// radiance(surface, to_viewer) where a pixel's ray meets the scene.
template <class Radiance>
PreviewImage rendered(const PreviewView& view, const Radiance& radiance) {
  PreviewImage image{view.width(), view.height(), {}, {}};
  const auto pixels = static_cast<std::size_t>(image.width) * image.height;
  image.radiance.resize(pixels);
  std::vector<char> covered(pixels);
  tbb::parallel_for(0, image.height, [&](int row) {
    for (int column = 0; column < image.width; ++column) {
      const auto hit = hit_of(view, column, row);
      if (!hit) continue;
      const std::size_t k = static_cast<std::size_t>(row) * image.width + column;
      covered[k] = 1;
      image.radiance[k] = radiance(hit->surface, hit->to_viewer);
    }
  });
  image.covered.assign(covered.begin(), covered.end());
  return image;
}

}  // namespace

PreviewImage render_lamp(const ReflectionTowards& f, const Specular& specular,
                         const PreviewView& view) {
  const Direction lamp = lamp_of(view);
  return rendered(view, [&](const Basis& surface, Direction to_viewer) {
    const Direction wi = surface.to_local(lamp), wo = surface.to_local(to_viewer);
    if (!(wi.z > 0)) return Rgb();
    return kPi * wi.z * f(wo)(wi) + kPi * mirrored(specular, wo, wi);
  });
}

PreviewImage render(const ReflectionTowards& f, const PreviewView& view,
                    const ReflectedLight& reflected) {
  if (view.light == PreviewLight::lamp) return render_lamp(f, reflected.specular(), view);
  return rendered(view, [&](const Basis& surface, Direction to_viewer) {
    return reflected(surface, to_viewer);
  });
}

}  // namespace lamella
