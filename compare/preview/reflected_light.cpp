#include "compare/preview/reflected_light.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "compare/preview/environment_sum.h"
#include "compare/truth/lobe_cells.h"

namespace lamella {
namespace {

// What the middles of nodes may leave of a lobe's energy, were all their errors of one sign. They
// are not: a peak's tops and flanks differ in it.
constexpr double kMiddleTolerance = 1e-2;
// Radians across a node at most, whatever the lobe.
constexpr double kMostExtent = 0.2;
// Nodes that cross the horizon are halved down to this extent [radians]: the cosine there is as
// small.
constexpr double kHorizonExtent = 0.05;
// Where halving ends [radians].
constexpr double kLeastExtent = 2e-4;
constexpr double kLeastMu = 1e-3;

// Angles of w_o crowd towards grazing.
double angle_mu(double k) {
  const double most = std::acos(kLeastMu);
  return std::cos(most * (1 - std::pow(1 - k / ReflectedLight::kAngles, 1.5)));
}

double place_of_mu(double mu) {
  const double left = 1 - std::acos(std::clamp(mu, kLeastMu, 1.0)) / std::acos(kLeastMu);
  return ReflectedLight::kAngles * (1 - std::cbrt(left * left));
}

// A frame about n in which w_o has the azimuth 0.
Frame<double> frame_of(Direction n, Direction to_viewer) {
  const Direction across = to_viewer - dot(to_viewer, n) * n;
  if (dot(across, across) < 1e-20) return frame_around(n);
  const Direction x = normalized(across);
  return {x, cross(n, x), n};
}

double square(double x) { return x * x; }

// Density [1/sr] of the blur of a mirror image. In the squared chord q, of which a solid angle
// about the image is pi dq, it falls linearly.
double mirror_disc(Direction w, Direction image) {
  static const double most = square(2 * std::sin(kMirrorRadius / 2));
  const Direction away = w - image;
  return std::max(0.0, 1 - dot(away, away) / most) * 2 / (kPi * most);
}

}  // namespace

ReflectedLight::ReflectedLight(Reflection f, const Environment& environment)
    : ReflectedLight(
          [f = std::move(f)](Direction wo) { return [&f, wo](Direction wi) { return f(wi, wo); }; },
          environment) {}

ReflectedLight::ReflectedLight(ReflectionTowards f, const Environment& environment,
                               Specular specular, int azimuths)
    : f_(std::move(f)),
      specular_(std::move(specular)),
      environment_(environment),
      azimuths_(azimuths),
      albedos_(static_cast<std::size_t>(azimuths) * (kAngles + 1)),
      sizes_(kAngles + 1) {
  // lobe_cells knows one side of the plane of w_o = (sine, 0, mu).
  const int sides = azimuths > 1 ? 2 : 1;
  tbb::parallel_for(0, kAngles + 1, [&](int k) {
    const double mu = angle_mu(k);
    for (int azimuth = 0; azimuth < azimuths_; ++azimuth) {
      const double phi = 2 * kPi * azimuth / azimuths_, c = std::cos(phi), s = std::sin(phi);
      const Direction wo = direction_from_mu_phi(mu, phi);
      const auto lobe_of_wo = f_(wo);
      Rgb& albedo = albedos_[static_cast<std::size_t>(azimuth) * (kAngles + 1) + k];
      if (specular_) albedo = specular_(wo);
      for (int side = 0; side < sides; ++side) {
        const LobeCells lobe = lobe_cells(
            [&](Direction w) {
              if (side == 1) w.y = -w.y;
              return lobe_of_wo(
                  azimuths_ == 1 ? w : Direction{c * w.x - s * w.y, s * w.x + c * w.y, w.z});
            },
            mu);
        albedo += 1.0 / sides * lobe.energy;
        if (environment_.is_uniform()) continue;
        // The finest that any azimuth needs.
        Sizes sizes = sizes_of(lobe);
        if (sizes_[k].empty()) {
          sizes_[k] = std::move(sizes);
          continue;
        }
        for (std::size_t j = 0; j < sizes.size(); ++j)
          sizes_[k][j] = std::min(sizes_[k][j], sizes[j]);
      }
    }
  });
}

// A cell of which n nodes are made owes 1/n of what its own middle would: least nodes for a given
// error in all where n goes like the root of that.
ReflectedLight::Sizes ReflectedLight::sizes_of(const LobeCells& lobe) {
  Sizes sizes(kColumns * kRows, static_cast<float>(kMostExtent));
  double roots = 0;
  for (const LobeCells::Cell& cell : lobe.cells) roots += std::sqrt(cell.middle_error);
  const double allowed = kMiddleTolerance * lobe.energy.max() / 2;  // half a disc
  for (const LobeCells::Cell& cell : lobe.cells) {
    const double nodes = std::sqrt(cell.middle_error) * roots / allowed;
    if (!(nodes > 0)) continue;
    const auto size = static_cast<float>(cell.size / std::sqrt(nodes));
    const double h = cell.size / 2;
    for (int j = row_of(cell.y - h); j <= row_of(cell.y + h); ++j)
      for (int i = column_of(cell.x - h); i <= column_of(cell.x + h); ++i) {
        float& s = sizes[j * kColumns + i];
        s = std::min(s, size);
      }
  }
  // A node reaches beyond the place where its extent is asked for: extents grow no faster than the
  // distance from where they are small. Once over all places, there and back.
  constexpr float kStep = 2.f / kColumns, kDiagonal = 1.41421356f * kStep;
  static_assert(kColumns == 2 * kRows, "places are squares");
  const auto relax = [&](int i, int j, int di, int dj, float step) {
    if (i + di < 0 || i + di >= kColumns || j + dj < 0 || j + dj >= kRows) return;
    float& s = sizes[j * kColumns + i];
    s = std::min(s, sizes[(j + dj) * kColumns + i + di] + step);
  };
  for (const int d : {-1, 1})
    for (int j = d < 0 ? 0 : kRows - 1; j >= 0 && j < kRows; j -= d)
      for (int i = d < 0 ? 0 : kColumns - 1; i >= 0 && i < kColumns; i -= d) {
        relax(i, j, d, 0, kStep);
        relax(i, j, 0, d, kStep);
        relax(i, j, -1, d, kDiagonal);
        relax(i, j, 1, d, kDiagonal);
      }
  return sizes;
}

int ReflectedLight::column_of(double x) {
  return std::clamp(static_cast<int>((x + 1) / 2 * kColumns), 0, kColumns - 1);
}

int ReflectedLight::row_of(double y) {
  return std::clamp(static_cast<int>(y * kRows), 0, kRows - 1);
}

Rgb ReflectedLight::albedo_at(int azimuth, double mu_o) const {
  const double place = place_of_mu(mu_o);
  const int k = std::min(static_cast<int>(place), kAngles - 1);
  const double x = place - k;
  const Rgb* of = &albedos_[static_cast<std::size_t>(azimuth) * (kAngles + 1)];
  return (1 - x) * of[k] + x * of[k + 1];
}

Rgb ReflectedLight::albedo(double mu_o, double phi_o) const {
  if (azimuths_ == 1) return albedo_at(0, mu_o);
  const double turn = phi_o / (2 * kPi), place = (turn - std::floor(turn)) * azimuths_;
  const int from = std::min(static_cast<int>(place), azimuths_ - 1);
  const double x = place - from;
  return (1 - x) * albedo_at(from, mu_o) + x * albedo_at((from + 1) % azimuths_, mu_o);
}

Rgb mirrored(const Specular& specular, Direction wo, Direction wi) {
  if (!specular) return {};
  const double density = mirror_disc(wi, {-wo.x, -wo.y, wo.z});
  return density > 0 ? density * specular(wo) : Rgb();
}

double ReflectedLight::largest_extent(std::size_t angle, Direction local) const {
  const DiscPoint p = on_lambert_disc(local);
  const auto at = static_cast<std::size_t>(row_of(std::abs(p.y)) * kColumns + column_of(p.x));
  return std::max<double>(std::min(sizes_[angle][at], sizes_[angle + 1][at]), kLeastExtent);
}

// The lobe of one surface and viewer, summed over the tree's nodes.
struct ReflectedLight::Gathering {
  const ReflectedLight& light;
  Frame<double> frame;
  std::function<Rgb(Direction)> f;
  std::size_t angle;
  // To the frame in which w_o has the azimuth 0.
  double turn_cosine, turn_sine;
  Rgb sum{};

  void add(Rgb flux, Direction centroid) {
    const double cosine = dot(centroid, frame.n);
    if (cosine <= 0) return;
    const Direction local = normalized(frame.to_local(centroid));
    sum += cosine * (f(local) * flux);
  }

  // Whether a rectangle is to be halved; nothing where it lies below the horizon.
  [[nodiscard]] std::optional<bool> is_large(Direction middle,
                                             const Environment::Extent& extent) const {
    const Direction local = frame.to_local(middle);
    const double radius = (extent.latitude + extent.longitude) / 2;
    if (local.z <= -radius) return std::nullopt;
    const double across = std::max(extent.latitude, extent.longitude);
    if (local.z < radius && across > kHorizonExtent) return true;
    return across >
           light.largest_extent(angle, {turn_cosine * local.x + turn_sine * local.y,
                                        turn_cosine * local.y - turn_sine * local.x, local.z});
  }
};

// The disc about the mirror image of the viewer.
struct ReflectedLight::Mirror {
  Direction image, normal;
  Rgb sum{};

  void add(Rgb flux, Direction centroid) {
    if (dot(centroid, normal) <= 0) return;
    sum += mirror_disc(normalized(centroid), image) * flux;
  }

  // Nothing where a rectangle lies outside of the disc.
  [[nodiscard]] std::optional<bool> is_large(Direction middle,
                                             const Environment::Extent& extent) const {
    const double radius = (extent.latitude + extent.longitude) / 2;
    const Direction away = middle - image;
    // The chord of an angle a is 2 sin(a / 2).
    if (const double reach = kMirrorRadius + radius;
        reach < kPi && dot(away, away) > square(2 * std::sin(reach / 2)))
      return std::nullopt;
    return std::max(extent.latitude, extent.longitude) > kMirrorRadius / 8;
  }
};

Rgb ReflectedLight::operator()(Direction n, Direction to_viewer) const {
  return (*this)(frame_of(n, to_viewer), to_viewer);
}

Rgb ReflectedLight::operator()(const Frame<double>& surface, Direction to_viewer) const {
  const Frame<double> frame = azimuths_ == 1 ? frame_of(surface.n, to_viewer) : surface;
  const Direction wo = frame.to_local(to_viewer);
  const double phi = azimuths_ == 1 ? 0 : azimuth(wo);
  const Rgb uniform = environment_.uniform() * albedo(wo.z, phi);
  if (environment_.is_uniform()) return uniform;
  const Environment::Node& whole = environment_.nodes().front();
  const auto angle =
      static_cast<std::size_t>(std::min(static_cast<int>(place_of_mu(wo.z)), kAngles - 1));
  Gathering gathering{*this, frame, f_(wo), angle, std::cos(phi), std::sin(phi)};
  EnvironmentSum(environment_, gathering).visit(whole);
  if (!specular_) return uniform + gathering.sum;
  Mirror mirror{2 * wo.z * frame.n - to_viewer, frame.n};
  EnvironmentSum(environment_, mirror).visit(whole);
  return uniform + gathering.sum + specular_(wo) * mirror.sum;
}

}  // namespace lamella
