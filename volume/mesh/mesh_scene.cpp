#include "volume/mesh/mesh_scene.h"

// Embree 4 and 3, as in volume/grains/grain_scene.cpp.
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "volume/grains/grain_scene.h"

namespace lamella {
namespace {

RTCDevice mesh_device() {
  static const RTCDevice shared = [] {
    const RTCDevice made = rtcNewDevice(nullptr);
    if (!made) throw GeometryError("Embree does not start");
    return made;
  }();
  return shared;
}

RTCRay ray_of(Direction origin, Direction d) {
  RTCRay ray;
  ray.org_x = static_cast<float>(origin.x);
  ray.org_y = static_cast<float>(origin.y);
  ray.org_z = static_cast<float>(origin.z);
  ray.dir_x = static_cast<float>(d.x);
  ray.dir_y = static_cast<float>(d.y);
  ray.dir_z = static_cast<float>(d.z);
  ray.tnear = 0;
  ray.tfar = std::numeric_limits<float>::infinity();
  ray.time = 0;
  ray.mask = ~0U;
  ray.id = 0;
  ray.flags = 0;
  return ray;
}

void find(RTCScene scene, RTCRayHit& query) {
#if RTC_VERSION_MAJOR >= 4
  rtcIntersect1(scene, &query);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &query);
#endif
}

void find_any(RTCScene scene, RTCRay& ray) {
#if RTC_VERSION_MAJOR >= 4
  rtcOccluded1(scene, &ray);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &ray);
#endif
}

}  // namespace

struct MeshScene::Implementation {
  RTCScene scene = nullptr;
  ~Implementation() {
    if (scene) rtcReleaseScene(scene);
  }
};

MeshScene::MeshScene(TriangleMesh mesh)
    : mesh_(std::move(mesh)), implementation_(std::make_unique<Implementation>()) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Direction low{kInfinity, kInfinity, kInfinity}, high = -low;
  for (const TriangleMesh::Vertex& v : mesh_.vertices) {
    low = {std::min(low.x, v.position.x), std::min(low.y, v.position.y),
           std::min(low.z, v.position.z)};
    high = {std::max(high.x, v.position.x), std::max(high.y, v.position.y),
            std::max(high.z, v.position.z)};
  }
  centre_ = 0.5 * (low + high);
  radius_ = std::max(0.5 * length(high - low), 1e-12);
  const RTCGeometry geometry = rtcNewGeometry(mesh_device(), RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* positions = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                              3 * sizeof(float), mesh_.vertices.size()));
  auto* indices = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(std::uint32_t), mesh_.triangles.size()));
  if (!positions || !indices) {
    rtcReleaseGeometry(geometry);
    throw GeometryError("Embree cannot hold the mesh: too little memory?");
  }
  for (const TriangleMesh::Vertex& v : mesh_.vertices) {
    *positions++ = static_cast<float>(v.position.x);
    *positions++ = static_cast<float>(v.position.y);
    *positions++ = static_cast<float>(v.position.z);
  }
  for (const auto& triangle : mesh_.triangles)
    for (const std::uint32_t corner : triangle) *indices++ = corner;
  rtcCommitGeometry(geometry);
  RTCScene scene = implementation_->scene = rtcNewScene(mesh_device());
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  tbb::this_task_arena::isolate([&] { rtcCommitScene(scene); });
  if (rtcGetDeviceError(mesh_device()) != RTC_ERROR_NONE)
    throw GeometryError("Embree cannot build the mesh: too little memory?");
}

MeshScene::~MeshScene() = default;

std::optional<MeshHit> MeshScene::trace(Direction origin, Direction d) const {
  RTCRayHit query;
  query.ray = ray_of(origin, d);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  find(implementation_->scene, query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const auto& corners = mesh_.triangles[query.hit.primID];
  const TriangleMesh::Vertex &a = mesh_.vertices[corners[0]], &b = mesh_.vertices[corners[1]],
                             &c = mesh_.vertices[corners[2]];
  const double s = static_cast<double>(query.hit.u), t = static_cast<double>(query.hit.v);
  const double r = 1 - s - t;
  MeshHit hit;
  hit.distance = static_cast<double>(query.ray.tfar);
  hit.point = r * a.position + s * b.position + t * c.position;
  const Direction ab = b.position - a.position, ac = c.position - a.position;
  const Direction area = cross(ab, ac);
  hit.face_normal = length(area) > 0 ? normalized(area) : -d;
  const Direction normal = r * a.normal + s * b.normal + t * c.normal;
  hit.normal = length(normal) > 0 ? normalized(normal) : hit.face_normal;
  hit.u = r * a.u + s * b.u + t * c.u;
  hit.v = r * a.v + s * b.v + t * c.v;
  // d(point)/du from the places of the corners.
  const double u1 = b.u - a.u, v1 = b.v - a.v, u2 = c.u - a.u, v2 = c.v - a.v;
  const double determinant = u1 * v2 - u2 * v1;
  Direction along = determinant != 0 ? (1 / determinant) * (v2 * ab - v1 * ac) : ab;
  along = along - dot(along, hit.normal) * hit.normal;
  hit.along_u = length(along) > 0 ? normalized(along) : frame_around(hit.normal).s;
  return hit;
}

bool MeshScene::is_free(Direction origin, Direction d) const {
  RTCRay ray = ray_of(origin, d);
  find_any(implementation_->scene, ray);
  return ray.tfar >= 0;
}

}  // namespace lamella
