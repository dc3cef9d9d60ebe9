#include "compare/request/direction_pairs.h"

#include <fmt/format.h>

#include <array>
#include <boost/math/special_functions/cos_pi.hpp>
#include <boost/math/special_functions/sin_pi.hpp>
#include <charconv>
#include <cmath>

#include "compare/request/errors.h"

namespace lamella {
namespace {

std::string trimmed(std::string text) {
  std::erase_if(text, [](char c) { return c == ' ' || c == '\r' || c == '\t'; });
  return text;
}

Direction from_cosine(double mu, double phi_in_degrees) {
  const double s = std::sqrt((1 - mu) * (1 + mu));
  return {s * boost::math::cos_pi(phi_in_degrees / 180),
          s * boost::math::sin_pi(phi_in_degrees / 180), mu};
}

}  // namespace

DirectionPairs read_pairs(std::istream& in, const std::string& file) {
  DirectionPairs out;
  out.file = file;
  const std::string allowed =
      "theta_i,phi_i,theta_o,phi_o or mu_i,phi_i,mu_o,phi_o (angles in degrees)";
  std::string line;
  int number = 1;
  if (!std::getline(in, line))
    throw UsageError(
        fmt::format("{}:1: found an empty file; allowed: CSV with the header {}", file, allowed));
  if (line.starts_with("\xef\xbb\xbf")) line.erase(0, 3);
  out.header = trimmed(line);
  const bool angles = out.header == "theta_i,phi_i,theta_o,phi_o";
  if (!angles && out.header != "mu_i,phi_i,mu_o,phi_o")
    throw UsageError(
        fmt::format("{}:1: found the header \"{}\"; allowed: {}", file, out.header, allowed));
  while (std::getline(in, line)) {
    ++number;
    const std::string row = trimmed(line);
    if (row.empty()) continue;
    std::array<double, 4> values{};
    const char* at = row.data();
    const char* const end = row.data() + row.size();
    for (int k = 0; k < 4; ++k) {
      if (at < end && *at == '+') ++at;
      const auto [next, error] = std::from_chars(at, end, values[k]);
      const bool last = k == 3;
      if (error != std::errc{} || (last ? next != end : next == end || *next != ','))
        throw UsageError(fmt::format("{}:{}: found \"{}\"; allowed: four numbers, {}", file, number,
                                     row, out.header));
      at = next + !last;
    }
    for (const int k : {0, 2}) {
      const double lower = angles ? 0 : -1, upper = angles ? 180 : 1;
      if (!(values[k] >= lower && values[k] <= upper))
        throw UsageError(fmt::format("{}:{}: {}: found {}; allowed: a number in [{}, {}]", file,
                                     number,
                                     std::string(angles ? "theta" : "mu") + (k ? "_o" : "_i"),
                                     to_text(values[k]), lower, upper));
      if (!std::isfinite(values[k + 1]))
        throw UsageError(fmt::format("{}:{}: {}: found {}; allowed: a finite number", file, number,
                                     k ? "phi_o" : "phi_i", to_text(values[k + 1])));
    }
    const auto direction = [&](int k) {
      return angles ? direction_from_degrees(values[k], values[k + 1])
                    : from_cosine(values[k], values[k + 1]);
    };
    out.rows.push_back(row);
    out.lines.push_back(number);
    out.pairs.push_back({direction(0), direction(2)});
  }
  return out;
}

void refuse_pair(const DirectionPairs& pairs, std::size_t k, const std::string& message) {
  throw UsageError(
      fmt::format("{}:{}: found \"{}\", {}", pairs.file, pairs.lines[k], pairs.rows[k], message));
}

}  // namespace lamella
