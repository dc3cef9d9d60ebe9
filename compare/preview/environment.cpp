#include "compare/preview/environment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "compare/files/exr_parts.h"
#include "compare/request/errors.h"

namespace lamella {

// Light of a block or of many: integrals over solid angle, without and with the direction.
struct Environment::Light {
  Rgb flux;
  Direction moment{0, 0, 0};  // of the channels' mean
};

// The texels that a picture has, a rectangle of the sphere; the others are black.
struct Environment::Picture {
  std::int64_t width, height;                                // of the sphere
  std::int64_t left, top, columns, rows;                     // of the rectangle
  std::function<Rgb(std::int64_t x, std::int64_t y)> texel;  // from the rectangle's corner
};

Direction lat_long_direction(double longitude, double polar_angle) {
  const double s = std::sin(polar_angle);
  return {s * std::sin(longitude), std::cos(polar_angle), -s * std::cos(longitude)};
}

void Environment::keep(const Picture& p) {
  columns_ = static_cast<int>(std::min<std::int64_t>(p.width, kMostColumns));
  rows_ = static_cast<int>(std::min<std::int64_t>(p.height, kMostRows));
  blocks_are_texels_ = columns_ == p.width && rows_ == p.height;
  uniform_ = Rgb(0);
  if (p.columns == p.width && p.rows == p.height) {
    uniform_ = Rgb(std::numeric_limits<double>::infinity());
    for (std::int64_t y = 0; y < p.rows; ++y)
      for (std::int64_t x = 0; x < p.columns; ++x) {
        const Rgb value = p.texel(x, y);
        for (int c = 0; c < 3; ++c) uniform_[c] = std::min(uniform_[c], value[c]);
      }
  }
  // The direction (sin t sin l, cos t, -sin t cos l) times sin t dt dl, integrated over each texel:
  // factors of its columns and of its rows.
  std::vector<double> along_x, along_z;
  for (std::int64_t x = 0; x < p.columns; ++x) {
    const double n = static_cast<double>(p.width), column = static_cast<double>(p.left + x);
    const double left = kPi * (2 * column / n - 1), right = kPi * (2 * (column + 1) / n - 1);
    along_x.push_back(std::cos(left) - std::cos(right));
    along_z.push_back(std::sin(left) - std::sin(right));
  }
  const double width = 2 * kPi / static_cast<double>(p.width);
  std::vector<Light> blocks(static_cast<std::size_t>(columns_) * rows_);
  for (std::int64_t y = 0; y < p.rows; ++y) {
    const double n = static_cast<double>(p.height), row = static_cast<double>(p.top + y);
    const double top = kPi * row / n, bottom = kPi * (row + 1) / n;
    const double solid_angle = width * (std::cos(top) - std::cos(bottom));
    const double in_plane = (bottom - top) / 2 - (std::sin(2 * bottom) - std::sin(2 * top)) / 4;
    const double up = width * (std::cos(2 * top) - std::cos(2 * bottom)) / 4;
    const auto block_row = static_cast<std::size_t>((p.top + y) * rows_ / p.height);
    for (std::int64_t x = 0; x < p.columns; ++x) {
      const Rgb above = p.texel(x, y) - uniform_;
      const double mean = (above.r + above.g + above.b) / 3;
      if (mean == 0) continue;
      const auto k = static_cast<std::size_t>(x);
      Light& to = blocks[block_row * static_cast<std::size_t>(columns_) +
                         static_cast<std::size_t>((p.left + x) * columns_ / p.width)];
      to.flux += solid_angle * above;
      to.moment = to.moment + mean * Direction{in_plane * along_x[k], up, in_plane * along_z[k]};
    }
  }
  for (int k = 0; k <= 2 * columns_; ++k) {
    sine_of_longitude_.push_back(std::sin(longitude(k / 2.0)));
    cosine_of_longitude_.push_back(std::cos(longitude(k / 2.0)));
  }
  for (int k = 0; k <= 2 * rows_; ++k) {
    sine_of_angle_.push_back(std::sin(polar_angle(k / 2.0)));
    cosine_of_angle_.push_back(std::cos(polar_angle(k / 2.0)));
  }
  nodes_.push_back(
      {{}, {}, 0, static_cast<std::uint16_t>(columns_), 0, static_cast<std::uint16_t>(rows_), -1});
  build(0, blocks);
  if (nodes_[0].flux[0] == 0 && nodes_[0].flux[1] == 0 && nodes_[0].flux[2] == 0) nodes_.clear();
}

// Halves a node along its longer side down to single blocks, and adds up on the way back.
Environment::Light Environment::build(std::int32_t index, const std::vector<Light>& blocks) {
  const auto at = static_cast<std::size_t>(index);
  const Node node = nodes_[at];
  Light light;
  if (node.columns == 1 && node.rows == 1) {
    light = blocks[static_cast<std::size_t>(node.row) * static_cast<std::size_t>(columns_) +
                   node.column];
  } else {
    const Extent e = extent(node);
    const bool by_rows = node.columns == 1 || (node.rows > 1 && e.latitude >= e.longitude);
    Node first = node, second = node;
    if (by_rows) {
      first.rows = node.rows / 2;
      second.row = node.row + first.rows;
      second.rows = node.rows - first.rows;
    } else {
      first.columns = node.columns / 2;
      second.column = node.column + first.columns;
      second.columns = node.columns - first.columns;
    }
    const std::size_t children = nodes_.size();
    nodes_.push_back(first);
    nodes_.push_back(second);
    for (const std::size_t child : {children, children + 1}) {
      const Light part = build(static_cast<std::int32_t>(child), blocks);
      light.flux += part.flux;
      light.moment = light.moment + part.moment;
    }
    if (light.flux == Rgb(0))
      nodes_.resize(children);
    else
      nodes_[at].children = static_cast<std::int32_t>(children);
  }
  const double mean = (light.flux.r + light.flux.g + light.flux.b) / 3;
  for (int c = 0; c < 3; ++c) nodes_[at].flux[c] = static_cast<float>(light.flux[c]);
  if (mean > 0) {
    const Direction w = 1 / mean * light.moment;
    nodes_[at].centroid[0] = static_cast<float>(w.x);
    nodes_[at].centroid[1] = static_cast<float>(w.y);
    nodes_[at].centroid[2] = static_cast<float>(w.z);
  }
  return light;
}

Direction Environment::middle(const Node& node) const {
  const auto l = static_cast<std::size_t>(2 * node.column + node.columns);
  const auto t = static_cast<std::size_t>(2 * node.row + node.rows);
  return {sine_of_angle_[t] * sine_of_longitude_[l], cosine_of_angle_[t],
          -sine_of_angle_[t] * cosine_of_longitude_[l]};
}

Environment::Extent Environment::extent(const Node& node) const {
  const auto top = static_cast<std::size_t>(2 * node.row);
  const auto bottom = static_cast<std::size_t>(2 * (node.row + node.rows));
  const bool crosses_equator = 2 * node.row < rows_ && 2 * (node.row + node.rows) > rows_;
  const double sine = crosses_equator ? 1 : std::max(sine_of_angle_[top], sine_of_angle_[bottom]);
  return {kPi * node.rows / rows_, 2 * kPi * node.columns / columns_ * sine};
}

Environment::Environment(int width, int height, const std::vector<Rgb>& texels) {
  keep({width, height, 0, 0, width, height, [&](std::int64_t x, std::int64_t y) {
          return texels[static_cast<std::size_t>(y * width + x)];
        }});
}

Environment::Environment(const std::string& path) {
  const std::vector<ExrPart> parts = read_exr_parts(path);
  const std::vector<ExrColors> found = find_colors(parts);
  if (found.empty())
    throw UsageError(fmt::format(
        "--environment {}: found channels {}; allowed: a lat-long EXR with R, G, B in any part or "
        "layer, or Y",
        path, channels_text(parts)));
  const ExrColors& colors = found.front();
  const ExrPart& part = parts[static_cast<std::size_t>(colors.part)];
  const ExrWindow &data = part.data, &display = part.display;
  const std::int64_t left = std::max(data.left, display.left),
                     top = std::max(data.top, display.top);
  const std::int64_t columns = std::min(data.right, display.right) - left + 1;
  const std::int64_t rows = std::min(data.bottom, display.bottom) - top + 1;
  if (columns < 1 || rows < 1)
    throw UsageError(fmt::format(
        "--environment {}: found a data window ({}) outside of the display window ({}); allowed: "
        "windows that meet",
        path, data.text(), display.text()));
  const ExrImage image = read_exr_part(path, colors.part, colors.channels);
  const auto value = [&](std::int64_t x, std::int64_t y, int c) {
    const std::size_t channel = colors.channels.size() == 3 ? static_cast<std::size_t>(c) : 0;
    return static_cast<double>(image.channels[channel].second[static_cast<std::size_t>(
        (top - data.top + y) * image.width + left - data.left + x)]);
  };
  for (std::int64_t y = 0; y < rows; ++y)
    for (std::int64_t x = 0; x < columns; ++x)
      for (int c = 0; c < static_cast<int>(colors.channels.size()); ++c)
        if (const double v = value(x, y, c); !(v >= 0 && std::isfinite(v)))
          throw UsageError(fmt::format(
              "--environment {}: found {} in channel {} at x {}, y {}; allowed: finite numbers "
              "from 0",
              path, v, colors.channels[static_cast<std::size_t>(c)], left + x, top + y));
  keep({display.width(), display.height(), left - display.left, top - display.top, columns, rows,
        [&](std::int64_t x, std::int64_t y) {
          return Rgb(value(x, y, 0), value(x, y, 1), value(x, y, 2));
        }});
  if (parts.size() > 1)
    source_ = fmt::format("part {}{}", colors.part,
                          part.name.empty() ? "" : fmt::format(" \"{}\"", part.name));
  if (!colors.layer.empty())
    source_ += fmt::format("{}layer {}", source_.empty() ? "" : ", ", colors.layer);
  if (found.size() > 1)
    source_ += fmt::format("{}the first of {} pictures in the file", source_.empty() ? "" : ", ",
                           found.size());
}

}  // namespace lamella
