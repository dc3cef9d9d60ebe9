#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "compare/drawing/color_map.h"

struct gdImageStruct;

namespace lamella {

/// Bitmap fonts that are part of the drawing library: the same pixels everywhere.
enum class Font { small, bold, title };
enum class Align { left, center, right };

/// A picture being drawn: pixels from the top left, white at first. What falls outside is cut off.
class Canvas {
 public:
  Canvas(int width, int height);

  void fill(int x, int y, int width, int height, Color color);
  void outline(int x, int y, int width, int height, Color color);
  void pixel(int x, int y, Color color);
  /// Mixes a colour in, coverage in [0, 1].
  void blend(int x, int y, Color color, double coverage);
  /// An anti-aliased ring, or disc if inner <= 0. Radii and centre in pixels; the centre of the
  /// pixel (x, y) is (x + 0.5, y + 0.5).
  void ring(double x, double y, double inner, double outer, Color color, double opacity = 1);
  /// An anti-aliased cross of two diagonal strokes, `arm` pixels from the centre each way.
  void cross(double x, double y, double arm, double stroke, Color color);
  /// One line of text, its top at y. Of what is not ASCII only the degree sign is drawn, the rest
  /// becomes '?'.
  void text(int x, int y, std::string_view utf8, Font font, Align align, Color color);
  /// The same, read from below, centred about y, its left at x.
  void text_upwards(int x, int y, std::string_view utf8, Font font, Color color);

  /// PNG bytes; equal pictures give equal bytes.
  [[nodiscard]] std::string png() const;

 private:
  struct Destroy {
    void operator()(gdImageStruct* image) const;
  };
  std::unique_ptr<gdImageStruct, Destroy> image_;
};

[[nodiscard]] int text_width(std::string_view utf8, Font font);
[[nodiscard]] int text_height(Font font);
/// Breaks a text at spaces into lines of at most `width` pixels; longer words are cut.
[[nodiscard]] std::vector<std::string> wrapped(std::string_view utf8, Font font, int width);
/// The text, or its beginning and "..." where it is wider than `width` pixels.
[[nodiscard]] std::string shortened(std::string_view utf8, Font font, int width);

}  // namespace lamella
