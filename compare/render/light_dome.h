#pragma once

#include <optional>
#include <string>
#include <vector>

#include "phase/math/color.h"
#include "phase/math/direction.h"

namespace lamella {

/// Generated skies: the same radiance 1 from all sides; the CIE's standard general sky, clear (type
/// 12, bluish, brightest about the lamp) or overcast (type 1), over a grey ground; none, the lamp
/// alone.
enum class SkyKind { uniform, clear, overcast, none };

/// Light that comes from far away: a lat-long picture as Environment has them (y up, the middle
/// column is -z), and a lamp: a disc of angular radius kLampRadius that gives a perpendicular
/// surface the irradiance pi. Directions are unit and point to the light.
class LightDome {
 public:
  static constexpr double kLampRadius = 0.5 * kPi / 180;

  /// Of a sky. `lamp`: where the disc stands; nothing: there is none. A sky without the lamp gives
  /// a horizontal surface the irradiance pi; the uniform one gives every surface that.
  LightDome(SkyKind sky, std::optional<Direction> lamp);
  /// Of a picture file (files/picture_file.h). Throws UsageError, naming `--environment`.
  LightDome(const std::string& path, std::optional<Direction> lamp);

  [[nodiscard]] Rgb radiance(Direction w) const;

  struct Sample {
    Direction w;
    Rgb radiance;
    double density;  ///< [1/sr]
  };
  /// A direction by importance: texels by their flux, and the lamp. Nothing where all is dark. Each
  /// u is uniform in (0, 1).
  [[nodiscard]] std::optional<Sample> sample(double u1, double u2, double u3) const;
  /// The density with which `sample` gives w.
  [[nodiscard]] double density(Direction w) const;

 private:
  void prepare(std::optional<Direction> lamp);
  [[nodiscard]] std::size_t texel_of(Direction w) const;
  [[nodiscard]] double solid_angle(std::size_t row) const;
  [[nodiscard]] bool in_lamp(Direction w) const;

  int columns_ = 1, rows_ = 1;
  std::vector<Rgb> texels_;         // row by row from the top
  std::vector<double> cumulative_;  // of the texels' fluxes, up to 1
  std::optional<Direction> lamp_;
  double lamp_share_ = 0;  // of the samples
};

/// A sky as a lat-long picture, row by row from the top left. `sun`: the direction of the lamp.
[[nodiscard]] std::vector<Rgb> sky_texels(SkyKind sky, int columns, int rows, Direction sun);

}  // namespace lamella
