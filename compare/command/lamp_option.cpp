#include "compare/command/lamp_option.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "compare/request/errors.h"
#include "compare/request/numbers.h"

namespace lamella {

LampAngles lamp_angles(const std::string& text, std::string_view besides) {
  const std::size_t comma = text.find(',');
  const auto theta = parse_number(std::string_view(text).substr(0, comma));
  const auto phi =
      comma == std::string::npos ? std::optional(0.0) : parse_number(text.substr(comma + 1));
  if (!theta || !phi || !(*theta >= 0 && *theta < 180) || !std::isfinite(*phi))
    throw UsageError(
        fmt::format("--light: found \"{}\"; allowed: THETA[,PHI] in degrees, THETA in [0, 180){}",
                    text, besides));
  return {*theta, *phi};
}

}  // namespace lamella
