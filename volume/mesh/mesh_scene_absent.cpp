// Stands in for mesh_scene.cpp where there is no Embree.
#include "volume/grains/grain_scene.h"
#include "volume/mesh/mesh_scene.h"

namespace lamella {

struct MeshScene::Implementation {};

MeshScene::MeshScene(TriangleMesh mesh) : mesh_(std::move(mesh)) {
  GrainScene::require_available();
}
MeshScene::~MeshScene() = default;
std::optional<MeshHit> MeshScene::trace(Direction, Direction) const { return std::nullopt; }
bool MeshScene::is_free(Direction, Direction) const { return true; }

}  // namespace lamella
