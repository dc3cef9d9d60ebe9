#pragma once

#include "analytic/model/model.h"

namespace lamella {

/// f = albedo / pi for reflection from either side, 0 for transmission.
[[nodiscard]] ModelInfo lambert_model();

}  // namespace lamella
