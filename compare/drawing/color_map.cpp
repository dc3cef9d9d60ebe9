#include "compare/drawing/color_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "compare/drawing/viridis_table.h"

namespace lamella {
namespace {

constexpr std::array<std::uint32_t, 11> kBlueRed = {0x053061, 0x2166ac, 0x4393c3, 0x92c5de,
                                                    0xd1e5f0, 0xf7f7f7, 0xfddbc7, 0xf4a582,
                                                    0xd6604d, 0xb2182b, 0x67001f};

Color interpolate(std::span<const std::uint32_t> points, double t) {
  const double x = t * static_cast<double>(points.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(x), points.size() - 2);
  const double fraction = x - static_cast<double>(i);
  const auto mix = [&](int shift) {
    const double a = (points[i] >> shift) & 0xff, b = (points[i + 1] >> shift) & 0xff;
    return static_cast<std::uint8_t>(std::lround(a + fraction * (b - a)));
  };
  return {mix(16), mix(8), mix(0)};
}

}  // namespace

Color viridis(double t) {
  constexpr std::size_t kLast = kViridis.size() - 1;
  const double at =
      static_cast<double>(kViridis.size()) * (std::isnan(t) ? 0 : std::clamp(t, 0.0, 1.0));
  const std::uint32_t c = kViridis[std::min(static_cast<std::size_t>(at), kLast)];
  return {static_cast<std::uint8_t>(c >> 16), static_cast<std::uint8_t>(c >> 8 & 0xff),
          static_cast<std::uint8_t>(c & 0xff)};
}

Color diverging_color(double t) {
  return interpolate(kBlueRed, std::isnan(t) ? 0.5 : (std::clamp(t, -1.0, 1.0) + 1) / 2);
}

}  // namespace lamella
