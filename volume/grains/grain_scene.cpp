#include "volume/grains/grain_scene.h"

// Embree 4 and 3, all differences between which are in this file.
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <vector>

namespace lamella {
namespace {

#if RTC_VERSION_MAJOR >= 4
using Context = RTCRayQueryContext;
#else
using Context = RTCIntersectContext;
#endif

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Of the extent of the scene: rounding the origin of a ray to floats moves it by 2^-24 of its
// coordinates, rounding its direction by 2^-24 of the way along it, which is at most the diagonal
// of the tile's box; Embree's robust traversal adds a few units of the last place. 2^-20 of the
// extent is above their sum.
constexpr double kRounding = 0x1p-20;
// Of the radius squared: depth inside of a grain that rounding in double precision explains.
constexpr double kInsideTolerance = 1e-9;

/// A sphere: a grain in coordinates whose z is divided by beta.
struct Ball {
  double x, y, z;
};

/// A ray in the stretched coordinates: what the callbacks need beside Embree's copy in floats.
/// First the context, which is all that Embree knows of it.
struct Query {
  Context context;
  Direction o, d;
  double a;                 // d . d
  double t = kInfinity;     // nearest hit so far
  std::int64_t grain = -1;  // and its grain
  bool any = false;         // stop at the first
  bool inside = false;      // began inside of a grain
};

std::atomic<std::int64_t> memory_in_use{0};

RTCDevice device() {
  static const RTCDevice shared = [] {
    const RTCDevice made = rtcNewDevice(nullptr);
    if (!made) throw GeometryError("Embree does not start");
    rtcSetDeviceMemoryMonitorFunction(
        made,
        [](void*, ssize_t bytes, bool) {
          memory_in_use += bytes;
          return true;
        },
        nullptr);
    return made;
  }();
  return shared;
}

}  // namespace

struct GrainScene::Implementation {
  double unit = 1;          // mm; all lengths below are in it, so that Embree's floats hold them
  GrainGeometry geometry;   // its radius in [1, 2)
  std::vector<Ball> balls;  // those that reach over the edge of the tile once more on the far side
  double radius2 = 0, pad = 0;
  double highest = -kInfinity, lowest = kInfinity;  // of any grain, not stretched
  RTCScene scene = nullptr;
  mutable std::atomic<std::uint64_t> holes{0};

  ~Implementation() {
    if (scene) rtcReleaseScene(scene);
  }

  /// The distance to where the ray enters the ball, infinite if it does not. A ray that begins
  /// inside and goes on inwards (rounding at the edge between two grains) enters at once.
  [[nodiscard]] double entry(Query& q, unsigned int k) const {
    const Ball& c = balls[k];
    const Direction m{q.o.x - c.x, q.o.y - c.y, q.o.z - c.z};
    const double b = dot(m, q.d), outside = dot(m, m) - radius2;
    if (outside < -kInsideTolerance * radius2) q.inside = true;
    if (b >= 0) return kInfinity;
    if (outside <= 0) return 0;
    // Half chord squared by the nearest point, which keeps its precision far away.
    const Direction nearest = m - (b / q.a) * q.d;
    const double half2 = radius2 - dot(nearest, nearest);
    if (half2 <= 0) return kInfinity;
    return std::max(0.0, (-b - std::sqrt(half2 * q.a)) / q.a);
  }

  static void bounds(const RTCBoundsFunctionArguments* args) {
    const auto& self = *static_cast<const Implementation*>(args->geometryUserPtr);
    const Ball& c = self.balls[args->primID];
    const double r = self.geometry.radius + self.pad;
    RTCBounds& box = *args->bounds_o;
    box.lower_x = static_cast<float>(c.x - r);
    box.lower_y = static_cast<float>(c.y - r);
    box.lower_z = static_cast<float>(c.z - r);
    box.upper_x = static_cast<float>(c.x + r);
    box.upper_y = static_cast<float>(c.y + r);
    box.upper_z = static_cast<float>(c.z + r);
  }

  /// Takes the ball if it is the nearest yet. Gives the new end of Embree's ray, or nothing.
  void meet(Query& q, unsigned int k, float& tfar) const {
    const double t = entry(q, k);
    if (t < q.t || (t == q.t && t < kInfinity && k < q.grain)) {
      q.t = t;
      q.grain = k;
      tfar = q.any ? -std::numeric_limits<float>::infinity()
                   : std::nextafter(static_cast<float>(t), std::numeric_limits<float>::infinity());
    }
  }
  static void intersect(const RTCIntersectFunctionNArguments* args) {
    if (!args->valid[0]) return;
    auto& ray = *reinterpret_cast<RTCRayHit*>(args->rayhit);
    auto& q = *reinterpret_cast<Query*>(args->context);
    static_cast<const Implementation*>(args->geometryUserPtr)->meet(q, args->primID, ray.ray.tfar);
  }
  static void occluded(const RTCOccludedFunctionNArguments* args) {
    if (!args->valid[0]) return;
    auto& ray = *reinterpret_cast<RTCRay*>(args->ray);
    auto& q = *reinterpret_cast<Query*>(args->context);
    static_cast<const Implementation*>(args->geometryUserPtr)->meet(q, args->primID, ray.tfar);
  }

  void build(std::span<const Direction> centres) {
    const double tile = geometry.tile, r = geometry.radius;
    balls.reserve(centres.size() + centres.size() / 4);
    for (const Direction& centre : centres) {
      const Direction p = (1 / unit) * centre;
      for (int i = p.x > tile - r ? -1 : 0; i <= (p.x < r ? 1 : 0); ++i)
        for (int j = p.y > tile - r ? -1 : 0; j <= (p.y < r ? 1 : 0); ++j)
          balls.push_back({p.x + i * tile, p.y + j * tile, p.z / geometry.beta});
      highest = std::max(highest, p.z + geometry.beta * r);
      lowest = std::min(lowest, p.z - geometry.beta * r);
    }
    if (!geometry.is_bed()) lowest = 0;
    radius2 = r * r;
    const double height = (geometry.top() - geometry.bottom()) / geometry.beta;
    pad = kRounding * (2 * tile + height + 2 * r);
    scene = rtcNewScene(device());
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    if (!balls.empty()) {
      const RTCGeometry g = rtcNewGeometry(device(), RTC_GEOMETRY_TYPE_USER);
      rtcSetGeometryUserPrimitiveCount(g, static_cast<unsigned int>(balls.size()));
      rtcSetGeometryUserData(g, this);
      rtcSetGeometryBoundsFunction(g, bounds, nullptr);
      rtcSetGeometryIntersectFunction(g, intersect);
      rtcSetGeometryOccludedFunction(g, occluded);
      rtcCommitGeometry(g);
      rtcAttachGeometry(scene, g);
      rtcReleaseGeometry(g);
    }
    // Embree builds with tasks of its own: a thread that waits for them takes up no batch of walks.
    tbb::this_task_arena::isolate([&] { rtcCommitScene(scene); });
    if (rtcGetDeviceError(device()) != RTC_ERROR_NONE)
      throw GeometryError("Embree cannot build the scene: too little memory?");
  }

  /// Asks Embree for the nearest grain (or any) up to the distance `end`, o and d stretched.
  void ask(Query& q, double end) const {
    q.a = dot(q.d, q.d);
    q.t = end;
    q.grain = -1;
    RTCRayHit ray;
    ray.ray.org_x = static_cast<float>(q.o.x);
    ray.ray.org_y = static_cast<float>(q.o.y);
    ray.ray.org_z = static_cast<float>(q.o.z);
    ray.ray.dir_x = static_cast<float>(q.d.x);
    ray.ray.dir_y = static_cast<float>(q.d.y);
    ray.ray.dir_z = static_cast<float>(q.d.z);
    ray.ray.tnear = 0;
    ray.ray.tfar = std::nextafter(static_cast<float>(end), std::numeric_limits<float>::infinity());
    ray.ray.time = 0;
    ray.ray.mask = ~0U;
    ray.ray.id = 0;
    ray.ray.flags = 0;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
    rtcInitRayQueryContext(&q.context);
    if (q.any) {
      RTCOccludedArguments args;
      rtcInitOccludedArguments(&args);
      args.context = &q.context;
      rtcOccluded1(scene, &ray.ray, &args);
    } else {
      RTCIntersectArguments args;
      rtcInitIntersectArguments(&args);
      args.context = &q.context;
      rtcIntersect1(scene, &ray, &args);
    }
#else
    rtcInitIntersectContext(&q.context);
    if (q.any)
      rtcOccluded1(scene, &q.context, &ray.ray);
    else
      rtcIntersect1(scene, &q.context, &ray);
#endif
  }

  [[nodiscard]] Direction wrapped(Direction p) const {
    p.x -= geometry.tile * std::floor(p.x / geometry.tile);
    p.y -= geometry.tile * std::floor(p.y / geometry.tile);
    return p;
  }

  [[nodiscard]] GrainHit follow(Direction o, Direction d, bool any) const {
    const double tile = geometry.tile, stretch = 1 / geometry.beta;
    const auto leave = [&]() -> GrainHit {
      if (d.z > 0) return {.end = RayEnd::up};
      if (!(d.z < 0)) return {.end = RayEnd::lost};
      Direction p = o + ((geometry.bottom() - o.z) / d.z) * d;
      p.z = geometry.bottom();
      return {.end = RayEnd::down, .point = wrapped(p), .normal = {0, 0, 1}};
    };
    if (balls.empty()) return leave();
    // Above or below all grains there is nothing to cross.
    const double outside = d.z < 0 ? o.z - highest : lowest - o.z;
    if (outside > 0 && d.z != 0) {
      o = o + (outside / std::abs(d.z)) * d;
      o = wrapped(o);
    }
    Query q;
    q.any = any;
    for (int tiles = 0; tiles < kMostTiles; ++tiles) {
      const double to_edge = d.z > 0   ? (highest - o.z) / d.z
                             : d.z < 0 ? (lowest - o.z) / d.z
                                       : kInfinity;
      if (!(to_edge > 0)) return leave();
      const double tx = d.x > 0 ? (tile - o.x) / d.x : d.x < 0 ? -o.x / d.x : kInfinity;
      const double ty = d.y > 0 ? (tile - o.y) / d.y : d.y < 0 ? -o.y / d.y : kInfinity;
      const double end = std::max(0.0, std::min({to_edge, tx, ty}));
      q.o = {o.x, o.y, o.z * stretch};
      q.d = {d.x, d.y, d.z * stretch};
      ask(q, end);
      if (tiles == 0 && q.inside) ++holes;
      if (q.grain >= 0) {
        if (any) return {.end = RayEnd::grain};
        const Ball& c = balls[q.grain];
        // The point on the ball itself, so that errors do not grow along a walk.
        const Direction n = normalized(q.o + q.t * q.d - Direction{c.x, c.y, c.z});
        const Direction p{c.x + geometry.radius * n.x, c.y + geometry.radius * n.y,
                          geometry.beta * (c.z + geometry.radius * n.z)};
        return {.end = RayEnd::grain,
                .point = p,
                .normal = geometry.beta == 1 ? n : normalized(Direction{n.x, n.y, n.z * stretch})};
      }
      o = o + end * d;
      if (end == to_edge) return leave();
      if (end == tx) o.x = d.x > 0 ? 0 : tile;
      if (end == ty) o.y = d.y > 0 ? 0 : tile;
    }
    return {.end = RayEnd::lost};
  }
};

GrainScene::GrainScene(const GrainGeometry& geometry, std::span<const Direction> centres)
    : implementation_(std::make_unique<Implementation>()) {
  implementation_->unit = geometry.length_unit();
  implementation_->geometry = geometry.in_units();
  implementation_->build(centres);
}

GrainScene::~GrainScene() = default;

GrainHit GrainScene::trace(Direction origin, Direction d) const {
  const double unit = implementation_->unit;
  GrainHit hit = implementation_->follow((1 / unit) * origin, d, false);
  hit.point = unit * hit.point;
  return hit;
}

bool GrainScene::is_free(Direction origin, Direction d) const {
  const RayEnd end = implementation_->follow((1 / implementation_->unit) * origin, d, true).end;
  return end == RayEnd::up || end == RayEnd::down;
}

bool GrainScene::is_inside(Direction point) const {
  // A short ray is enough: Embree reports the boxes that hold its origin.
  const Implementation& self = *implementation_;
  const double stretch = 1 / self.geometry.beta;
  Query q;
  q.o = self.wrapped((1 / self.unit) * point);
  q.o.z *= stretch;
  q.d = {0, 0, 1};
  self.ask(q, 0.25 * self.geometry.radius);
  return q.inside;
}

std::uint64_t GrainScene::holes() const { return implementation_->holes; }

std::int64_t GrainScene::embree_bytes() { return memory_in_use; }

bool GrainScene::is_available() { return true; }
void GrainScene::require_available() {}

}  // namespace lamella
