#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "compare/command/command.h"
#include "compare/files/output_folder.h"
#include "compare/report/json_report.h"
#include "compare/request/errors.h"
#include "compare/request/model_request.h"
#include "compare/request/numbers.h"
#include "compare/tabulate/tables.h"
#include "phase/medium/media.h"

namespace lamella {
namespace {

// A closed form, or the phase function of a medium (media.NAME).
struct Tabulated {
  PairFunction value;
  BoundModel model{};
  bool color = false, medium = false;
};

Tabulated source_of(const std::vector<std::string>& words) {
  const ModelRequest request = parse_model_words(words);
  Tabulated source;
  if (!request.name.starts_with("media.")) {
    source.model = bind_model(request, nullptr);
    source.color = source.model.parameters.has_color();
    source.value = [&model = *source.model.model](Direction wi, Direction wo) {
      return model.eval(wi, wo);
    };
    return source;
  }
  const MediumInfo* info = find_medium(request.name.substr(6));
  if (!info) {
    std::vector<std::string> names;
    for (const MediumInfo& m : media()) names.push_back("media." + m.name);
    throw UsageError(fmt::format("\"{}\": unknown; allowed: a closed form (lamella models), {}",
                                 request.name, fmt::join(names, ", ")));
  }
  Parameters parameters = read_parameters(request.name, info->parameters, request.values);
  try {
    source.value = [medium = info->make(parameters)](Direction wi, Direction wo) {
      return Rgb(phase(medium, wi, wo).density);
    };
  } catch (const ParameterError& error) {
    throw UsageError(fmt::format("{}: {}", request.name, error.what()));
  }
  source.medium = true;
  return source;
}

std::vector<double> cosines(const char* option, const std::vector<std::string>& given, bool below) {
  std::vector<double> list;
  for (const std::string& text : given) {
    const auto mu = parse_number(text);
    if (!mu || !(std::abs(*mu) <= 1) || *mu == 0 || (*mu < 0 && !below))
      throw UsageError(fmt::format("{}: found \"{}\"; allowed: a cosine in {}", option, text,
                                   below ? "[-1, 1] other than 0" : "(0, 1]"));
    list.push_back(*mu);
  }
  if (!list.empty()) return list;
  for (int k = 10; k >= 1; --k) list.push_back(k / 10.0);
  return list;
}

NumberTable albedos(const Tabulated& source, const std::vector<double>& mu) {
  NumberTable table{{"mu_i"}, {}};
  for (const char* name : {"albedo", "error"}) {
    if (source.color)
      for (const char* channel : {"_r", "_g", "_b"})
        table.columns.push_back(fmt::format("{}{}", name, channel));
    else
      table.columns.emplace_back(name);
  }
  for (const double m : mu) {
    const AlbedoEstimate a = source.model.model->albedo_with_error(direction_from_mu_phi(m, 0));
    std::vector<double> row{m};
    for (const Rgb& value : {a.value, a.error})
      for (int c = 0; c < (source.color ? 3 : 1); ++c) row.push_back(value[c]);
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string csv_of(const NumberTable& table) {
  std::string text = fmt::format("{}\n", fmt::join(table.columns, ","));
  for (const std::vector<double>& row : table.rows) {
    std::vector<std::string> numbers;
    for (const double x : row) {
      if (!std::isfinite(x)) throw std::domain_error("a value that is not finite");
      numbers.push_back(fmt::format("{:.17g}", x));
    }
    text += fmt::format("{}\n", fmt::join(numbers, ","));
  }
  return text;
}

}  // namespace

int tabulate_command(const Options& options, const TabulateOptions& asked,
                     const std::vector<std::string>& words) {
  const std::string what = words[0];
  const Tabulated source = source_of(words);
  if (asked.of == "legendre" && !source.medium)
    throw UsageError(
        fmt::format("tabulate --of legendre: found the closed form {}; allowed: media.NAME", what));
  if (asked.of == "albedo" && source.medium)
    throw UsageError(fmt::format(
        "tabulate --of albedo: found {}; allowed: a closed form (lamella models)", what));
  const bool below = source.medium || source.model.info->transmits;
  NumberTable table;
  try {
    if (asked.of == "legendre")
      table = legendre_table(source.value, asked.terms);
    else if (asked.of == "albedo")
      table = albedos(source, cosines("--mu-i", asked.mu_i, below));
    else
      table = fourier_table(source.value, cosines("--mu-i", asked.mu_i, below),
                            cosines("--mu-o", asked.mu_o, below), asked.terms, source.color);
  } catch (const std::invalid_argument& error) {
    throw UsageError(fmt::format("{}: {}", what, error.what()));
  }
  const std::string csv = csv_of(table);
  if (!options.output.empty())
    write_file(options.output, csv);
  else if (options.json != "-" && !options.quiet)
    fmt::print("{}", csv);
  nlohmann::ordered_json answer = {{"format", 1},
                                   {"command", "tabulate"},
                                   {"version", LAMELLA_VERSION},
                                   {"source", fmt::format("{}", fmt::join(words, ","))},
                                   {"of", asked.of},
                                   {"columns", table.columns},
                                   {"rows", table.rows}};
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
