#include "volume/run/incident_check.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "volume/grains/grain_scene.h"
#include "volume/grains/grain_walk.h"

namespace lamella {

Direction checked_incident(const Stack& stack, Direction wi) {
  wi = with_grazing_limit(wi);
  if (wi.z < 0 && !stack.is_open_below())
    throw std::invalid_argument(stack.substrate
                                    ? "light from below meets an opaque substrate"
                                    : "light from below cannot come through a half space");
  if (stack.grains()) {
    if (!stack.grains()->is_height_field()) GrainScene::require_available();
    if (std::abs(wi.z) < kGrainGrazingLimit)
      throw std::invalid_argument(fmt::format(
          "light at |mu| = {:.3g} on explicit geometry; allowed: |mu| of {} and above (theta up to "
          "{:.2f} degrees)",
          std::abs(wi.z), kGrainGrazingLimit, std::acos(kGrainGrazingLimit) * 180 / kPi));
  }
  return wi;
}

}  // namespace lamella
