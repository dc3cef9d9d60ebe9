#pragma once

#include <functional>
#include <vector>

#include "compare/preview/environment.h"
#include "compare/truth/lobe_cells.h"
#include "phase/math/color.h"
#include "phase/math/direction.h"

namespace lamella {

/// f [1/sr] of a surface, w_i and w_o above it.
using Reflection = std::function<Rgb(Direction wi, Direction wo)>;

/// The same for one w_o at a time, as a function of w_i: what depends on w_o alone is done once.
using ReflectionTowards = std::function<std::function<Rgb(Direction wi)>(Direction wo)>;

/// The share of light that a surface mirrors towards w_o as a delta, which is no part of f.
using Specular = std::function<Rgb(Direction wo)>;

/// Radius [radians] of the disc over which mirror images are blurred: 2 degrees, the width of a
/// pixel's reflection at the middle of a sphere, so that a lamp at infinity has an image.
inline constexpr double kMirrorRadius = 2 * kPi / 180;

/// What a delta makes of a lamp's irradiance across its rays: radiance per irradiance [1/sr] for a
/// viewer at w_o and a lamp at w_i, both relative to the normal z.
[[nodiscard]] Rgb mirrored(const Specular& specular, Direction wo, Direction wi);

/// Radiance that a surface sends to its viewer under light from everywhere: the integral of
/// f L mu_i over the hemisphere.
///
/// Light that is the same from all sides needs the directional albedo of w_o only, integrated once
/// over the cells of lobe_cells.h for kAngles angles of w_o and linear between them. The rest of a
/// picture is summed over the nodes of its tree (environment.h), each descended into until it is
/// small beside the lobe's own cells there: flux and cosine of a node are exact, and f is taken at
/// the centroid of the node's light. So a small sun has its whole irradiance wherever it stands,
/// and a narrow lobe is resolved wherever it lies. What is mirrored as a delta is seen as a disc of
/// kMirrorRadius about the mirror image, brightest in its middle. No random numbers: equal runs are
/// equal, whatever the number of threads.
///
/// Error, of the energy of a lobe: kLobeTolerance under uniform light; below 0.3 % under a picture
/// of any contrast (tests hold both at roughness 0.02 to 1).
class ReflectedLight {
 public:
  static constexpr int kAngles = 96;

  /// Runs in the calling thread's task arena. The environment must outlive this object. azimuths:
  /// of w_o, between which directional albedos are linear; 1: f has no preferred azimuth.
  ReflectedLight(ReflectionTowards f, const Environment& environment, Specular specular = {},
                 int azimuths = 1);
  ReflectedLight(Reflection f, const Environment& environment);

  /// n: the unit normal; to_viewer: unit, above the surface. For f without a preferred azimuth.
  [[nodiscard]] Rgb operator()(Direction n, Direction to_viewer) const;
  /// In the surface's frame, whose z is its normal.
  [[nodiscard]] Rgb operator()(const Frame<double>& surface, Direction to_viewer) const;

  [[nodiscard]] const Specular& specular() const { return specular_; }

  /// The share of light from all sides that is sent to a viewer at this cosine and azimuth.
  [[nodiscard]] Rgb albedo(double mu_o, double phi_o = 0) const;

 private:
  // Of Lambert's half disc (lobe_cells.h): x in [-1, 1], |y| in [0, 1].
  static constexpr int kColumns = 256, kRows = 128;
  [[nodiscard]] static int column_of(double x);
  [[nodiscard]] static int row_of(double y);
  // Of one angle: the largest extent [radians] of a node about a place of the half disc.
  using Sizes = std::vector<float>;
  [[nodiscard]] static Sizes sizes_of(const LobeCells& lobe);
  struct Gathering;
  struct Mirror;
  [[nodiscard]] double largest_extent(std::size_t angle, Direction local) const;
  [[nodiscard]] Rgb albedo_at(int azimuth, double mu_o) const;

  ReflectionTowards f_;
  Specular specular_;
  const Environment& environment_;
  int azimuths_;
  std::vector<Rgb> albedos_;  // by azimuth, then angle
  std::vector<Sizes> sizes_;
};

}  // namespace lamella
