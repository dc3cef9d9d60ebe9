#include "compare/request/percent.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

constexpr double kMost = 1e6, kLeast = 1e-8;
constexpr int kDigits = 2;

std::string plain(double percent, int decimals, bool signs) {
  return signs ? fmt::format("{:+.{}f} %", percent, decimals)
               : fmt::format("{:.{}f} %", percent, decimals);
}

/// Decimals that leave kDigits significant digits after rounding.
int decimals_of(double percent) {
  if (percent == 0) return 0;
  const std::string rounded = fmt::format("{:.{}e}", std::abs(percent), kDigits - 1);
  const int exponent = std::stoi(rounded.substr(rounded.find('e') + 1));
  return std::max(0, kDigits - 1 - exponent);
}

/// What no digits would show; else empty.
std::string beyond(double percent) {
  if (std::isnan(percent)) return "-";
  if (std::isinf(percent)) return percent > 0 ? "inf %" : "-inf %";
  if (std::abs(percent) > kMost)
    return fmt::format("{}{:.0f} %", percent > 0 ? "above " : "below -", kMost);
  return "";
}

std::string cell(double share, bool signs) {
  const double percent = 100 * share;
  const std::string text = beyond(percent);
  if (!text.empty()) return text;
  return plain(percent, std::abs(percent) < 99.995 ? 2 : 0, signs);
}

}  // namespace

std::string percent_text(double share) {
  const double percent = 100 * share;
  const std::string text = beyond(percent);
  if (!text.empty()) return text;
  if (percent != 0 && std::abs(percent) < kLeast)
    return fmt::format("{}{:.8f} %", percent > 0 ? "below " : "above -", kLeast);
  return plain(percent, decimals_of(percent), false);
}

std::string percent_cell(double share) { return cell(share, false); }

std::string signed_percent_cell(double share) { return cell(share, true); }

}  // namespace lamella
