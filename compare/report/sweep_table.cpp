#include "compare/report/sweep_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kWidth = 100, kIndent = 2;

struct Column {
  std::string name;
  std::vector<std::string> cells;  // one per point

  [[nodiscard]] std::size_t width() const {
    std::size_t widest = name.size();
    for (const std::string& cell : cells) widest = std::max(widest, cell.size());
    return widest + 2;
  }
};

double number_of(const Json& value) {
  return value.is_number() ? value.get<double>() : std::numeric_limits<double>::infinity();
}

std::string number_text(const Json& value) {
  return value.is_number() ? fmt::format("{:g}", value.get<double>()) : value.get<std::string>();
}

// "12.3 %", with a question mark where walks were too few to tell.
std::string error_cell(const Json& model) {
  double worst = 0;
  bool sufficient = true;
  for (const Json& lobe : model["lobes"]) {
    if (lobe["order"] != "all") continue;
    worst = std::max(worst, number_of(lobe["relative_rmse_without_noise"]));
    sufficient = sufficient && lobe["verdict"] != "insufficient";
  }
  return fmt::format("{}{}", std::isinf(worst) ? "inf" : fmt::format("{:.3g} %", 100 * worst),
                     sufficient ? "" : " ?");
}

// The energy farthest from 1 over directions and channels.
std::string energy_cell(const Json& runs) {
  double farthest = 1;
  for (const Json& run : runs)
    for (const Json& energy : run["energy"])
      if (std::abs(number_of(energy) - 1) > std::abs(farthest - 1)) farthest = number_of(energy);
  return fmt::format("{:.6f}", farthest);
}

std::vector<Column> parameter_columns(const Json& sweep) {
  std::vector<Column> columns;
  for (std::size_t a = 0; a < sweep["axes"].size(); ++a) {
    const Json& axis = sweep["axes"][a];
    Column column{axis["path"].get<std::string>(), {}};
    for (const Json& point : sweep["points"])
      column.cells.push_back(number_text(axis["values"][point["at"][a].get<std::size_t>()]));
    columns.push_back(std::move(column));
  }
  return columns;
}

// A column per model. Points need not have the same models: each has those that apply to it.
void add_model_columns(std::vector<Column>& columns, const Json& sweep,
                       std::string (*cell)(const Json&)) {
  const Json& points = sweep["points"];
  const std::size_t first = columns.size();
  for (std::size_t k = 0; k < points.size(); ++k) {
    std::map<std::string, int> seen;
    for (const Json& model : points[k]["answer"].value("models", Json::array())) {
      std::string name = model["name"].get<std::string>();
      if (const int before = seen[name]++; before > 0) name += fmt::format(" ({})", before + 1);
      auto column = std::find_if(columns.begin() + static_cast<std::ptrdiff_t>(first),
                                 columns.end(), [&](const Column& c) { return c.name == name; });
      if (column == columns.end())
        column =
            columns.insert(columns.end(), {name, std::vector<std::string>(points.size(), "-")});
      column->cells[k] = cell(model);
    }
  }
}

std::string block(const std::vector<const Column*>& columns) {
  std::string text;
  const std::size_t rows = columns.front()->cells.size();
  for (std::size_t row = 0; row <= rows; ++row) {
    text += std::string(kIndent, ' ');
    for (const Column* column : columns)
      text +=
          fmt::format("{:>{}}", row == 0 ? column->name : column->cells[row - 1], column->width());
    text += '\n';
  }
  return text;
}

}  // namespace

std::string sweep_table(const Json& sweep) {
  if (sweep["points"].empty()) return "";
  const std::vector<Column> parameters = parameter_columns(sweep);
  std::vector<Column> results;
  std::string text;
  if (sweep["of"] == "compare") {
    text =
        "\nlargest relative RMSE without noise over directions and sides, all orders (?: too few "
        "walks)\n";
    add_model_columns(results, sweep, error_cell);
  } else {
    text = "\nenergy farthest from 1 over directions and channels, and the furnace's verdict\n";
    const bool of_models = sweep["points"][0]["answer"].contains("models");
    if (of_models)
      add_model_columns(results, sweep,
                        [](const Json& model) { return energy_cell(model["runs"]); });
    else
      results.push_back({"energy", {}});
    Column verdict{"verdict", {}};
    for (const Json& point : sweep["points"]) {
      if (!of_models) results.front().cells.push_back(energy_cell(point["answer"]["runs"]));
      verdict.cells.push_back(point["answer"]["verdict"].get<std::string>());
    }
    results.push_back(std::move(verdict));
  }
  std::size_t at = 0;
  do {
    std::vector<const Column*> columns;
    std::size_t width = kIndent;
    for (const Column& column : parameters) {
      columns.push_back(&column);
      width += column.width();
    }
    const std::size_t begin = at;
    while (at < results.size() && (at == begin || width + results[at].width() <= kWidth)) {
      width += results[at].width();
      columns.push_back(&results[at++]);
    }
    text += block(columns) + "\n";
  } while (at < results.size());
  return text;
}

}  // namespace lamella
