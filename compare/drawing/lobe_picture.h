#pragma once

#include <string>
#include <vector>

#include "compare/drawing/canvas.h"
#include "volume/result/cell_grid.h"

namespace lamella {

/// One lobe for the eye: maps over the cells of one hemisphere, one channel (or luminance) of each.
/// A map has grid.cells() values, row by row as the grid counts them, or none: its panel is left
/// out. nan stands for a cell without a value, infinity is drawn as the end of the scale.
struct LobePicture {
  CellGrid grid;
  std::vector<double> truth;       ///< f [1/sr]
  std::vector<double> model;       ///< f [1/sr]
  std::vector<double> difference;  ///< model - truth [1/sr]
  std::vector<double> z;           ///< difference in standard errors, or in error bounds

  std::string title;
  std::string subtitle;  ///< may be empty
  std::string truth_label = "truth";
  std::string model_label = "model";
  double mu_i = 1;           ///< of w_i, whose place is marked
  bool transmitted = false;  ///< the hemisphere w_i is not in: -w_i is marked
  bool logarithmic = false;  ///< scale of truth and model
  bool bounded = false;      ///< the truth has error bounds, not standard errors
};

/// The file's bytes. Above, each map as a disc, the hemisphere seen along z from above, the lower
/// one too (radius sin theta_o, so that equal cells have equal area; phi = 0, the side of w_i, on
/// the right, counter-clockwise; a folded grid mirrored to the full circle); below, the same map as
/// a rectangle with phi to the right and mu^2 falling downwards; then the scales. truth and model
/// share one; that of the difference is symmetric about 0. z goes from -4 to 4, and cells beyond
/// are counted; where the truth is bounded the error over its bound, |z|, is shown on a logarithmic
/// scale. Equal input gives equal bytes. Throws std::invalid_argument for a map of the wrong size
/// or no map at all, PictureError without Cairo.
[[nodiscard]] std::string draw_lobe(const LobePicture& picture,
                                    PictureFormat format = PictureFormat::png);

/// Where draw_lobe puts things, in pixels from the top left: for those who look at single pixels.
struct PictureLayout {
  int width = 0, height = 0;
  int panels = 0;
  int disc_top = 0, rectangle_top = 0;

  static constexpr int kPanel = 256;      ///< diameter of a disc, width of a rectangle
  static constexpr int kRectangle = 160;  ///< height of a rectangle
  static constexpr int kLeft = 68, kGap = 76, kRight = 44;

  [[nodiscard]] static constexpr int panel_left(int panel) {
    return kLeft + panel * (kPanel + kGap);
  }
};

[[nodiscard]] PictureLayout layout_of(const LobePicture& picture);

}  // namespace lamella
