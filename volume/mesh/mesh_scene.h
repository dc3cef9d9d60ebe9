#pragma once

#include <memory>
#include <optional>

#include "volume/mesh/triangle_mesh.h"

namespace lamella {

/// Where a ray meets a mesh.
struct MeshHit {
  double distance = 0;
  Direction point, face_normal;  ///< of the triangle, unit, counter-clockwise outwards
  Direction normal, along_u;     ///< interpolated, unit; along_u: unit, in the plane of `normal`
  double u = 0, v = 0;
};

/// A mesh ready for rays (Embree).
class MeshScene {
 public:
  /// Throws GeometryError (volume/grains/grain_scene.h) without Embree, and where it cannot build.
  explicit MeshScene(TriangleMesh mesh);
  ~MeshScene();
  MeshScene(const MeshScene&) = delete;
  MeshScene& operator=(const MeshScene&) = delete;

  /// The first triangle along the ray from `origin` along the unit vector d, from either side. Any
  /// thread.
  [[nodiscard]] std::optional<MeshHit> trace(Direction origin, Direction d) const;
  /// Whether the ray meets nothing.
  [[nodiscard]] bool is_free(Direction origin, Direction d) const;
  /// The middle of the mesh's box, and half of its diagonal.
  [[nodiscard]] Direction centre() const { return centre_; }
  [[nodiscard]] double radius() const { return radius_; }

 private:
  struct Implementation;
  TriangleMesh mesh_;
  Direction centre_{0, 0, 0};
  double radius_ = 1;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace lamella
