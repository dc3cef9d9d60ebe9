#include "compare/drawing/color_map.h"

#include <algorithm>
#include <cmath>

#include "compare/drawing/red_blue_table.h"
#include "compare/drawing/viridis_table.h"

namespace lamella {
namespace {

Color color_of(std::uint32_t c) {
  return {static_cast<std::uint8_t>(c >> 16), static_cast<std::uint8_t>(c >> 8 & 0xff),
          static_cast<std::uint8_t>(c & 0xff)};
}

}  // namespace

Color viridis(double t) {
  constexpr std::size_t kLast = kViridis.size() - 1;
  const double at =
      static_cast<double>(kViridis.size()) * (std::isnan(t) ? 0 : std::clamp(t, 0.0, 1.0));
  return color_of(kViridis[std::min(static_cast<std::size_t>(at), kLast)]);
}

Color diverging_color(double t) {
  if (std::isnan(t) || t == 0) return color_of(kNeutral);
  constexpr std::size_t kHalf = kBlueRed.size() / 2;
  const auto step = std::min(
      static_cast<std::size_t>(static_cast<double>(kHalf) * std::min(std::abs(t), 1.0)), kHalf - 1);
  return color_of(kBlueRed[t > 0 ? kHalf + step : kHalf - 1 - step]);
}

}  // namespace lamella
