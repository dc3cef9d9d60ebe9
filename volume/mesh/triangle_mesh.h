#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include "phase/math/vec3.h"

namespace lamella {

/// A mesh that cannot be read. what() names file and line, what was found and what is allowed.
struct MeshError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A surface of triangles. Lengths have no unit. Every vertex has a normal (unit) and a place on
/// the picture of a stack's maps, (u, v).
struct TriangleMesh {
  struct Vertex {
    Direction position, normal;
    double u = 0, v = 0;
  };
  std::vector<Vertex> vertices{};
  std::vector<std::array<std::uint32_t, 3>> triangles{};  ///< counter-clockwise from outside
};

/// A patch of (columns + 1) x (rows + 1) vertices at position(u, v), u and v from 0 to 1, with the
/// normals of that surface, on the side of d/du x d/dv, by central differences.
template <class Position>
[[nodiscard]] TriangleMesh patch(int columns, int rows, const Position& position) {
  constexpr double kStep = 1e-4;
  TriangleMesh mesh;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      const double u = static_cast<double>(i) / columns, v = static_cast<double>(j) / rows;
      const Direction along_u = position(u + kStep, v) - position(u - kStep, v);
      const Direction along_v = position(u, v + kStep) - position(u, v - kStep);
      mesh.vertices.push_back({position(u, v), normalized(cross(along_u, along_v)), u, v});
    }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(j * (columns + 1) + i); };
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

/// A square cloth over a ball of radius 1 about the origin, y up: it lies on the ball, falls beside
/// it in folds, and ends above y = -1.2.
[[nodiscard]] TriangleMesh draped_cloth();
/// A tube of radius 0.32 about a trefoil, the (2, 3) torus knot, within 1.4 of the origin.
[[nodiscard]] TriangleMesh trefoil_knot();

/// Reads the triangles and polygons (convex, as fans) of a Wavefront OBJ file: v, vt, vn and f;
/// other lines are skipped. Missing normals are those of the triangles about a vertex, missing
/// places are 0. Throws MeshError: also for more than kMostTriangles and files above 512 MiB.
[[nodiscard]] TriangleMesh read_obj(const std::filesystem::path& path);
inline constexpr std::size_t kMostTriangles = std::size_t{1} << 23;

}  // namespace lamella
