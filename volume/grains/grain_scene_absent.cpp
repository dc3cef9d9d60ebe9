// Stands in for grain_scene.cpp where there is no Embree.
#include "volume/grains/grain_scene.h"

namespace lamella {

struct GrainScene::Implementation {};

bool GrainScene::is_available() { return false; }

void GrainScene::require_available() {
  throw GeometryError(
      "explicit geometry (sphere_bed, packed_sphere_bed, micrograins) needs Embree, and this "
      "lamella was built without (-DLAMELLA_EMBREE=OFF); allowed: layers of media, or a build with "
      "libembree-dev and -DLAMELLA_EMBREE=ON");
}

GrainScene::GrainScene(const GrainGeometry&, std::span<const Direction>) { require_available(); }
GrainScene::~GrainScene() = default;
GrainHit GrainScene::trace(Direction, Direction) const { return {}; }
bool GrainScene::is_free(Direction, Direction) const { return true; }
bool GrainScene::is_inside(Direction) const { return false; }
std::uint64_t GrainScene::holes() const { return 0; }
std::int64_t GrainScene::embree_bytes() { return 0; }

}  // namespace lamella
