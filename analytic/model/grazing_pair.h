#pragma once

#include <functional>
#include <optional>

#include "phase/math/color.h"
#include "phase/math/direction.h"

namespace lamella {

/// Whether both cosines count as 0: their absolute values lie below kGrazingLimit.
[[nodiscard]] bool grazes_twice(Direction wi, Direction wo);

/// The limit of f [1/sr] where both cosines vanish together, the azimuths staying, or nothing where
/// f has none: most models grow there like 1 / (mu_i + mu_o). f is asked at four pairs of cosines
/// between kGrazingLimit and 1e-120, and has a limit if the values are finite and agree within
/// 1e-9 of the largest, or within 1e-10 / sr.
[[nodiscard]] std::optional<Rgb> limit_where_both_graze(
    const std::function<Rgb(Direction wi, Direction wo)>& f, Direction wi, Direction wo);

}  // namespace lamella
