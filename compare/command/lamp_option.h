#pragma once

#include <string>
#include <string_view>

namespace lamella {

/// Where a lamp stands, in degrees from the viewer's direction and about it.
struct LampAngles {
  double theta, phi;
};

/// --light as THETA[,PHI], THETA in [0, 180). Throws UsageError, `besides` being what else the
/// option takes, as its text has it.
[[nodiscard]] LampAngles lamp_angles(const std::string& text, std::string_view besides = {});

}  // namespace lamella
