#include "compare/render/path_picture.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>

#include "compare/request/errors.h"
#include "phase/math/luminance.h"
#include "volume/grains/grain_scene.h"

namespace lamella {
namespace {

// The cameras of preview.cpp.
constexpr double kMargin = 1.04, kPitch = 14 * kPi / 180, kHalfField = 20 * kPi / 180;
// Meshes are seen from this much above the horizontal.
constexpr double kMeshPitch = 24 * kPi / 180;
const Direction kMeshView{0, -std::sin(kMeshPitch), -std::cos(kMeshPitch)};
// Share of the scene's size by which a ray begins off the surface: floats have 2^-24.
constexpr double kOffset = 2e-5;
constexpr double kLeastMu = 1e-9;
// Surfaces that a path or a ray to the light meets at most, sheets that it just passes among them.
constexpr int kMeetingBits = 12, kMostMeetings = 1 << kMeetingBits;

MeshHit sphere_hit(Direction p, double distance) {
  MeshHit hit;
  hit.distance = distance;
  hit.point = hit.face_normal = hit.normal = normalized(p);
  const Direction n = hit.normal;
  hit.u = std::atan2(n.x, n.z) / (2 * kPi) + 0.5;
  hit.v = 1 - std::acos(std::clamp(n.y, -1.0, 1.0)) / kPi;
  const Direction along = Direction{n.z, 0, -n.x};
  hit.along_u = length(along) > 1e-12 ? normalized(along) : Direction{1, 0, 0};
  return hit;
}

// The frame of a surface: x along u, z the normal on the viewer's side of an opaque surface.
Frame<double> surface_frame(const MeshHit& hit, Direction to_viewer, bool transmits) {
  Direction n = hit.normal, face = hit.face_normal;
  if (!transmits && dot(face, to_viewer) < 0) {
    n = -n;
    face = -face;
  }
  // An interpolated normal may point away from a viewer who sees the triangle.
  if (dot(n, to_viewer) * dot(face, to_viewer) <= 0) n = face;
  Direction x = hit.along_u - dot(hit.along_u, n) * n;
  x = length(x) > 1e-9 ? normalized(x) : frame_around(n).s;
  return {x, cross(n, x), n};
}

// The radiance of one path, and the weight that the limit of depth cut.
struct PathEnd {
  Rgb radiance{};
  double cut = 0;
};

class PathTracer {
 public:
  PathTracer(const ViewedObject& object, const SurfaceScatter& surface, const LightDome& light,
             const PathSettings& settings)
      : object_(object), surface_(surface), light_(light), settings_(settings) {}

  // Nothing where the camera's ray meets nothing.
  [[nodiscard]] std::optional<PathEnd> trace(double x, double y, RandomStream& stream,
                                             std::uint64_t number) const {
    ViewedObject::Ray ray = object_.camera(x, y);
    std::optional<MeshHit> hit = object_.trace(ray);
    if (!hit) return std::nullopt;
    PathEnd end;
    Rgb weight(1);
    // Of the direction that the path has; nothing: only paths find the light there.
    std::optional<double> density;
    std::uint64_t walk = number << kMeetingBits;
    for (int depth = 1, meetings = 1;; ++meetings) {
      const Direction to_viewer = -ray.d;
      const Frame<double> frame = surface_frame(*hit, to_viewer, surface_.transmits());
      const Direction wo = frame.to_local(to_viewer);
      if (std::abs(wo.z) < kLeastMu) return end;
      const double u1 = stream.uniform(), u2 = stream.uniform(), u3 = stream.uniform();
      const auto aimed = light_.sample(u1, u2, u3);
      LightAim aim{};
      bool aims = aimed.has_value();
      if (aims) {
        aim = {frame.to_local(aimed->w), aimed->density};
        aims = std::abs(aim.wi.z) > kLeastMu && (surface_.transmits() || aim.wi.z * wo.z > 0);
      }
      const Scattered scattered =
          surface_.scatter(hit->u, hit->v, wo, aims ? &aim : nullptr, settings_.seed, walk++);
      const double passes = aims && scattered.f != Rgb(0) ? passage(*hit, aimed->w) : 0;
      if (passes > 0)
        end.radiance +=
            passes * std::abs(aim.wi.z) / aimed->density * (weight * scattered.f * aimed->radiance);
      if (!scattered.next) return end;
      // A sheet that the path just passes leaves it what it was.
      if (!scattered.next->straight) density = scattered.next->density;
      weight = weight * scattered.next->weight;
      ray = object_.from(*hit, frame.to_world(scattered.next->wi));
      hit = object_.trace(ray);
      if (!hit) {
        const double share = density ? *density / (*density + light_.density(ray.d)) : 1;
        end.radiance += share * (weight * light_.radiance(ray.d));
        return end;
      }
      if (!scattered.next->straight) ++depth;
      if (depth > settings_.depth || meetings == kMostMeetings) {
        end.cut = luminance(weight);
        return end;
      }
    }
  }

 private:
  // The share of light from w that reaches a hit, through sheets that it passes without an event.
  [[nodiscard]] double passage(const MeshHit& from, Direction w) const {
    ViewedObject::Ray ray = object_.from(from, w);
    if (!surface_.transmits()) return object_.is_free(ray) ? 1 : 0;
    double share = 1;
    for (int k = 0; k < kMostMeetings && share > 0; ++k) {
      const std::optional<MeshHit> hit = object_.trace(ray);
      if (!hit) return share;
      const Direction local = surface_frame(*hit, -w, true).to_local(w);
      share *= surface_.uncollided(hit->u, hit->v, local);
      ray = object_.from(*hit, w);
    }
    return 0;
  }

  const ViewedObject& object_;
  const SurfaceScatter& surface_;
  const LightDome& light_;
  const PathSettings& settings_;
};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// The mean of value(pixel) / (reference^2 + a hundredth of its mean square) over the pixels whose
// variance is known in both pictures.
template <class Value>
double relative_mean(const PathPicture& picture, const PathPicture& reference, const Value& value) {
  std::vector<std::size_t> pixels;
  double square = 0;
  for (std::size_t k = 0; k < reference.samples.size(); ++k) {
    if (reference.samples[k] < 2 || picture.samples[k] < 2) continue;
    pixels.push_back(k);
    square += std::pow(luminance(reference.mean(k)), 2);
  }
  if (!(square > 0)) return 0;
  const auto count = static_cast<double>(pixels.size());
  double sum = 0;
  for (const std::size_t k : pixels)
    sum += value(k) / (std::pow(luminance(reference.mean(k)), 2) + 1e-2 * square / count);
  return sum / count;
}

}  // namespace

ViewedObject::ViewedObject(const std::string& shape) {
  if (shape == "sphere" || shape == "plane") {
    kind_ = shape == "sphere" ? Kind::sphere : Kind::plane;
    return;
  }
  kind_ = Kind::mesh;
  try {
    TriangleMesh mesh = shape == "cloth"  ? draped_cloth()
                        : shape == "knot" ? trefoil_knot()
                                          : read_obj(shape);
    frame(mesh);
    mesh_ = std::make_unique<MeshScene>(std::move(mesh));
  } catch (const MeshError& error) {
    throw UsageError(fmt::format("--shape: {} (or sphere, plane, cloth, knot)", error.what()));
  } catch (const GeometryError& error) {
    throw UsageError(fmt::format("--shape {}: {}", shape, error.what()));
  }
}

ViewedObject::ViewedObject(TriangleMesh mesh) : kind_(Kind::mesh) {
  frame(mesh);
  mesh_ = std::make_unique<MeshScene>(std::move(mesh));
}

int ViewedObject::rows(int columns) const { return kind_ == Kind::plane ? columns / 2 : columns; }

ViewedObject::Ray ViewedObject::camera(double x, double y) const {
  if (kind_ == Kind::sphere) return {{kMargin * x, kMargin * y, 2}, {0, 0, -1}};
  if (kind_ == Kind::plane) {
    const double field = std::tan(kHalfField);
    return {{0, 1, 0},
            normalized(Direction{field * x, -std::sin(kPitch) + field * y * std::cos(kPitch),
                                 -std::cos(kPitch) - field * y * std::sin(kPitch)})};
  }
  const Direction right{1, 0, 0}, up = cross(right, kMeshView);
  const Direction on_picture = middle_ + (half_width_ * x) * right + (half_width_ * y) * up;
  return {on_picture - (3 * mesh_->radius()) * kMeshView, kMeshView};
}

// The smallest square picture that holds the mesh.
void ViewedObject::frame(const TriangleMesh& mesh) {
  const Direction right{1, 0, 0}, up = cross(right, kMeshView);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::array<double, 3> low{kInfinity, kInfinity, kInfinity},
      high{-kInfinity, -kInfinity, -kInfinity};
  for (const TriangleMesh::Vertex& v : mesh.vertices) {
    const std::array at{dot(v.position, right), dot(v.position, up), dot(v.position, kMeshView)};
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], at[k]);
      high[k] = std::max(high[k], at[k]);
    }
  }
  const auto middle = [&](std::size_t k) { return 0.5 * (low[k] + high[k]); };
  middle_ = middle(0) * right + middle(1) * up + middle(2) * kMeshView;
  half_width_ = kMargin / 2 * std::max({high[0] - low[0], high[1] - low[1], 1e-12});
}

std::optional<MeshHit> ViewedObject::trace(const Ray& ray) const {
  if (kind_ == Kind::mesh) return mesh_->trace(ray.origin, ray.d);
  if (kind_ == Kind::plane) {
    if (!(ray.d.y * ray.origin.y < 0) || std::abs(ray.d.y) < 1e-3) return std::nullopt;
    MeshHit hit;
    hit.distance = -ray.origin.y / ray.d.y;
    hit.point = ray.origin + hit.distance * ray.d;
    hit.point.y = 0;
    hit.normal = hit.face_normal = {0, 1, 0};
    hit.along_u = {1, 0, 0};
    hit.u = hit.point.x;
    hit.v = -hit.point.z;
    return hit;
  }
  const double b = dot(ray.origin, ray.d), c = dot(ray.origin, ray.origin) - 1;
  const double square = b * b - c;
  if (square <= 0) return std::nullopt;
  const double root = std::sqrt(square);
  for (const double t : {-b - root, -b + root})
    if (t > 0) return sphere_hit(ray.origin + t * ray.d, t);
  return std::nullopt;
}

bool ViewedObject::is_free(const Ray& ray) const {
  return kind_ == Kind::mesh ? mesh_->is_free(ray.origin, ray.d) : !trace(ray);
}

ViewedObject::Ray ViewedObject::from(const MeshHit& hit, Direction d) const {
  const double side = dot(d, hit.face_normal) >= 0 ? 1 : -1;
  if (kind_ != Kind::mesh) return {hit.point + (side * 1e-9) * hit.face_normal, d};
  return {hit.point + (side * kOffset * mesh_->radius()) * hit.face_normal, d};
}

Rgb PathPicture::mean(std::size_t pixel) const {
  return samples[pixel] ? 1.0 / samples[pixel] * sum[pixel] : Rgb();
}

Rgb PathPicture::variance(std::size_t pixel) const {
  const double n = samples[pixel];
  if (n < 2) return {};
  const Rgb m = mean(pixel);
  Rgb out;
  for (int c = 0; c < 3; ++c) out[c] = std::max(0.0, square[pixel][c] / n - m[c] * m[c]) / (n - 1);
  return out;
}

PathPicture trace_picture(const ViewedObject& object, const SurfaceScatter& surface,
                          const LightDome& light, const PathSettings& settings,
                          const StopFlag* stop, const PathWatch& watch) {
  PathPicture picture;
  picture.width = settings.columns;
  picture.height = object.rows(settings.columns);
  const std::size_t pixels =
      static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
  picture.samples.resize(pixels);
  picture.sum.resize(pixels);
  picture.square.resize(pixels);
  std::vector<double> cut(pixels);
  const PathTracer tracer(object, surface, light, settings);
  const auto start = std::chrono::steady_clock::now();
  double next_checkpoint = settings.seconds ? *settings.seconds / 32 : 0;
  for (int pass = 0; pass < settings.samples && !(pass > 0 && is_set(stop)); ++pass) {
    tbb::parallel_for(0, picture.height, [&](int row) {
      for (int column = 0; column < picture.width; ++column) {
        const std::size_t k =
            static_cast<std::size_t>(row) * static_cast<std::size_t>(picture.width) +
            static_cast<std::size_t>(column);
        const std::uint64_t number = static_cast<std::uint64_t>(pass) * pixels + k;
        RandomStream stream(settings.seed, number, StreamPurpose::measure);
        const double x = 2 * (column + stream.uniform()) / picture.width - 1;
        const double y = (picture.height - 2 * (row + stream.uniform())) / picture.width;
        const auto end = tracer.trace(x, y, stream, number);
        if (!end) continue;
        ++picture.samples[k];
        picture.sum[k] += end->radiance;
        picture.square[k] += end->radiance * end->radiance;
        cut[k] += end->cut;
      }
    });
    picture.seconds = seconds_since(start);
    if (watch) watch(picture, pass + 1);
    if (!settings.seconds) continue;
    if (picture.seconds >= next_checkpoint && pass > 0) {
      picture.checkpoints.push_back({picture.seconds, pass + 1, relative_noise(picture, picture)});
      while (next_checkpoint <= picture.seconds) next_checkpoint *= 2;
    }
    if (picture.seconds >= *settings.seconds) break;
  }
  double samples = 0;
  for (std::size_t k = 0; k < pixels; ++k) {
    samples += picture.samples[k];
    picture.cut += cut[k];
  }
  if (samples > 0) picture.cut /= samples;
  return picture;
}

double relative_noise(const PathPicture& picture, const PathPicture& reference) {
  return relative_mean(picture, reference, [&](std::size_t k) {
    // Channels share their paths: standard errors add up with the weights of the luminance.
    const Rgb v = picture.variance(k);
    return std::pow(luminance(Rgb(std::sqrt(v.r), std::sqrt(v.g), std::sqrt(v.b))), 2);
  });
}

double relative_difference(const PathPicture& picture, const PathPicture& reference) {
  return relative_mean(picture, reference, [&](std::size_t k) {
    return std::pow(luminance(picture.mean(k)) - luminance(reference.mean(k)), 2);
  });
}

}  // namespace lamella
