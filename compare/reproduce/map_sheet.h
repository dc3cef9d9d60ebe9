#pragma once

#include <string>
#include <vector>

#include "compare/drawing/picture_format.h"

namespace lamella {

/// A sheet of square maps over two cosines: a row per quantity, a column per parameter.
struct MapSheet {
  /// Maps that share a colour scale.
  struct Row {
    std::string label;
    /// One map per column, each `side` x `side` values: row by row from the top, where the incoming
    /// cosine is highest; the outgoing one grows to the right. nan stays white.
    std::vector<std::vector<double>> maps;
    bool is_signed = false;  ///< a scale that is symmetric about 0
    /// The scale of the row before it.
    bool same_scale = false;
  };
  std::string title, subtitle;
  std::vector<std::string> columns;  ///< their labels
  std::vector<Row> rows;
  int side = 0;
};

/// The file's bytes; equal sheets give equal bytes. Throws std::invalid_argument for maps of the
/// wrong number or size, PictureError without Cairo.
[[nodiscard]] std::string draw_map_sheet(const MapSheet& sheet,
                                         PictureFormat format = PictureFormat::png);

}  // namespace lamella
