#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

#include "compare/drawing/color_map.h"
#include "compare/drawing/picture_format.h"
#include "compare/drawing/raster.h"

namespace lamella {

/// A picture that cannot be drawn: no Cairo in this build, or a failure of Cairo's. what() is one
/// line for the user.
struct PictureError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

enum class Font { small, bold, title };
enum class Align { left, center, right };

/// A picture being drawn with Cairo: white at first, coordinates in pixels from the top left; the
/// centre of the pixel (x, y) is (x + 0.5, y + 0.5). Parts outside the picture are cut off. All
/// shapes and texts are anti-aliased. Throws PictureError.
class Canvas {
 public:
  /// Whether this build has Cairo.
  [[nodiscard]] static bool is_available();
  /// Throws PictureError unless is_available().
  static void require_available();

  explicit Canvas(int width, int height, PictureFormat format = PictureFormat::png);
  ~Canvas();
  Canvas(Canvas&&) noexcept;
  Canvas& operator=(Canvas&&) noexcept;

  void fill(double x, double y, double width, double height, Color color);
  /// A frame of one pixel inside of a box of whole pixels.
  void outline(int x, int y, int width, int height, Color color);
  /// A ring, or a disc if inner <= 0.
  void ring(double x, double y, double inner, double outer, Color color);
  void line(double x0, double y0, double x1, double y1, double width, Color color);
  /// A cross of two diagonal strokes, `arm` pixels from the centre each way.
  void cross(double x, double y, double arm, double stroke, Color color);
  /// Pixels per unit of length that a raster should have: 1 for PNG, more where the picture may be
  /// enlarged.
  [[nodiscard]] int raster_scale() const;
  /// Lays a raster into a box; its pixels become rectangles with sharp edges.
  void paint(const Raster& raster, double x, double y, double width, double height);
  /// One line of text, its top at y. Bytes that are no UTF-8 become U+FFFD, control characters
  /// blanks.
  void text(double x, double y, std::string_view utf8, Font font, Align align, Color color);
  /// One line of text that reads upwards, centred about y, its left at x.
  void text_upwards(double x, double y, std::string_view utf8, Font font, Color color);

  /// Ends the drawing and gives the file's bytes. Equal pictures give equal bytes (with the same
  /// fonts on the machine).
  [[nodiscard]] std::string bytes();

 private:
  struct Drawing;
  std::unique_ptr<Drawing> drawing_;
};

/// Width of a line in pixels, rounded up. The font is DejaVu Sans, or what the system has for it.
[[nodiscard]] int text_width(std::string_view utf8, Font font);

}  // namespace lamella
