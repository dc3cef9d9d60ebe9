#pragma once

#include <optional>
#include <string>
#include <vector>

#include "compare/drawing/canvas.h"
#include "compare/drawing/color_scale.h"
#include "compare/preview/reflected_light.h"
#include "phase/math/color.h"

namespace lamella {

/// What is drawn: a sphere seen from far away along -z, or a plane seen by a camera close to it.
enum class PreviewScene { sphere, plane };
/// A distant lamp that gives a perpendicular surface the irradiance pi (so that white Lambert
/// facing it has the radiance 1), or light from everywhere.
enum class PreviewLight { lamp, environment };

[[nodiscard]] std::string to_text(PreviewScene scene);
[[nodiscard]] std::string to_text(PreviewLight light);

struct PreviewView {
  PreviewScene scene = PreviewScene::sphere;
  PreviewLight light = PreviewLight::lamp;
  int size = 192;  ///< of the sphere's square; the plane is as wide, half as high
  double lamp_theta = 45, lamp_phi = 45;  ///< degrees from the viewer, and from the right upwards
  [[nodiscard]] int width() const { return size; }
  [[nodiscard]] int height() const { return scene == PreviewScene::sphere ? size : size / 2; }
};

/// Radiance per pixel, row by row from the top left; `covered`: 0 where nothing is.
struct PreviewImage {
  int width = 0, height = 0;
  std::vector<Rgb> radiance;
  std::vector<bool> covered;
};

/// One sample in the middle of each pixel. `reflected`: f and what it reflects of an environment; a
/// lamp needs f and the delta alone. Runs in the calling thread's task arena.
[[nodiscard]] PreviewImage render(const ReflectionTowards& f, const PreviewView& view,
                                  const ReflectedLight& reflected);

/// The same under the lamp alone, of a surface that need not be integrated.
[[nodiscard]] PreviewImage render_lamp(const ReflectionTowards& f, const Specular& specular,
                                       const PreviewView& view);

/// A named picture of a view; the first of a view is the truth. `label`: what is written above it;
/// empty: the name.
struct PreviewColumn {
  std::string name;
  PreviewImage image;
  std::string label{};
  [[nodiscard]] const std::string& told() const { return label.empty() ? name : label; }
};

/// What the pictures of a view share.
struct PreviewScales {
  double white = 1;       ///< luminance shown as white: the truth's 99th percentile
  ColorScale difference;  ///< of the luminance, model - truth
};
[[nodiscard]] PreviewScales scales_of(const std::vector<PreviewColumn>& columns);

/// The mean of FLIP (flip.h) over the pixels that the truth covers, both pictures at the exposure
/// at which they are drawn. Noise counts.
[[nodiscard]] double flip_error(const PreviewImage& truth, const PreviewImage& picture);

/// PNG bytes of one picture; of the signed difference in luminance, model - truth.
[[nodiscard]] std::string picture_png(const PreviewImage& image, double white);
[[nodiscard]] std::string difference_png(const PreviewImage& truth, const PreviewImage& model,
                                         const ColorScale& scale);

/// The file's bytes: the pictures of a view side by side at one exposure (the truth's 99th
/// percentile is white), below each model its signed difference from the truth in luminance, with
/// the scale.
[[nodiscard]] std::string draw_preview(const std::string& title,
                                       const std::vector<PreviewColumn>& columns,
                                       PictureFormat format = PictureFormat::png);

/// The file's bytes: pictures of one size side by side, without differences. `white`: the luminance
/// shown as white; nothing: the 99th percentile of all pictures.
[[nodiscard]] std::string draw_gallery(const std::string& title,
                                       const std::vector<PreviewColumn>& columns,
                                       std::optional<double> white = {},
                                       PictureFormat format = PictureFormat::png);

}  // namespace lamella
