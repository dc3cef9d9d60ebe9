#include "compare/request/direction_pairs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <boost/math/special_functions/cos_pi.hpp>
#include <boost/math/special_functions/sin_pi.hpp>
#include <cmath>

#include "compare/request/csv_reader.h"
#include "compare/request/errors.h"
#include "compare/request/numbers.h"

namespace lamella {
namespace {

Direction from_cosine(double mu, double phi_in_degrees) {
  if (std::abs(phi_in_degrees) > 1e6) phi_in_degrees = std::fmod(phi_in_degrees, 360);
  const double s = std::sqrt((1 - mu) * (1 + mu));
  return {s * boost::math::cos_pi(phi_in_degrees / 180),
          s * boost::math::sin_pi(phi_in_degrees / 180), mu};
}

std::string joined(const std::vector<std::string>& fields) {
  return fmt::format("{}", fmt::join(fields, ","));
}

}  // namespace

DirectionPairs read_pairs(std::istream& in, const std::string& file) {
  DirectionPairs out;
  out.file = file;
  const std::string allowed =
      "theta_i,phi_i,theta_o,phi_o or mu_i,phi_i,mu_o,phi_o (angles in degrees)";
  CsvReader reader(in, file);
  const auto header = reader.next();
  if (!header)
    throw UsageError(
        fmt::format("{}:1: found an empty file; allowed: CSV with the header {}", file, allowed));
  out.header = joined(*header);
  const bool angles = out.header == "theta_i,phi_i,theta_o,phi_o";
  if (header->size() != 4 || (!angles && out.header != "mu_i,phi_i,mu_o,phi_o"))
    reader.refuse(fmt::format("{} column{}", header->size(), header->size() == 1 ? "" : "s"),
                  allowed);
  while (auto row = reader.next()) {
    if (row->size() != 4)
      reader.refuse(fmt::format("{} field{}", row->size(), row->size() == 1 ? "" : "s"),
                    "four numbers, " + out.header);
    std::array<double, 4> values{};
    for (std::size_t k = 0; k < 4; ++k) {
      std::string& field = (*row)[k];
      const auto number = reader.number_text(field);
      if (!number)
        reader.refuse(fmt::format("{} \"{}\"", (*header)[k], shown(field)),
                      "four numbers, " + out.header);
      field = *number;
      values.at(k) = *parse_number(field);
    }
    const auto refuse_number = [&](std::size_t k, const std::string& range) {
      throw UsageError(fmt::format("{}:{}: {}: found {}; allowed: {}", file, reader.line(),
                                   (*header)[k], to_text(values.at(k)), range));
    };
    for (const std::size_t k : {0U, 2U}) {
      const double lower = angles ? 0 : -1, upper = angles ? 180 : 1;
      if (!(values.at(k) >= lower && values.at(k) <= upper))
        refuse_number(k, fmt::format("a number in [{}, {}]", lower, upper));
      if (!std::isfinite(values.at(k + 1))) refuse_number(k + 1, "a finite number");
    }
    const auto direction = [&](std::size_t k) {
      return angles ? direction_from_degrees(values.at(k), values.at(k + 1))
                    : from_cosine(values.at(k), values.at(k + 1));
    };
    out.rows.push_back(joined(*row));
    out.lines.push_back(reader.line());
    out.pairs.push_back({direction(0), direction(2)});
  }
  return out;
}

void refuse_pair(const DirectionPairs& pairs, std::size_t k, const std::string& message) {
  throw UsageError(
      fmt::format("{}:{}: found \"{}\", {}", pairs.file, pairs.lines[k], pairs.rows[k], message));
}

}  // namespace lamella
