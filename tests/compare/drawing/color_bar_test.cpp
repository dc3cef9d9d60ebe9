#include "compare/drawing/color_bar.h"

#include <gtest/gtest.h>

#include "tests/compare/drawing/decoded_png.h"

namespace lamella {
namespace {

constexpr int kLeft = 30, kTop = 10, kWidth = 80;
constexpr Color kWhite{255, 255, 255};

Decoded drawn(OpenEnds open) {
  Canvas canvas(140, 60);
  draw_color_bar(canvas, fixed_signed_scale(4, 2), kLeft, kTop, kWidth, open);
  return Decoded(canvas.bytes());
}

// Height of the column of one colour at x, over all rows of the bar.
int height_of(const Decoded& image, int x, Color color) {
  int count = 0;
  for (int y = 0; y < kTop + 20; ++y) count += image.at(x, y) == color;
  return count;
}

TEST(ColorBar, ShowsTheScaleFromLowToHigh) {
  const Decoded image = drawn({});
  const ColorScale scale = fixed_signed_scale(4, 2);
  for (const int x : {0, 20, 40, 79})
    EXPECT_EQ(image.at(kLeft + x, kTop + 7), scale.color_at((x + 0.5) / kWidth)) << x;
}

TEST(ColorBar, HasAnArrowHeadAtEachOpenEndAndAtNoOther) {
  const Color low = diverging_color(-1), high = diverging_color(1);
  for (const OpenEnds open : {OpenEnds{false, false}, OpenEnds{true, false}, OpenEnds{false, true},
                              OpenEnds{true, true}}) {
    const Decoded image = drawn(open);
    // Outside of the frame, which is one pixel wide: columns of falling height, in the end's
    // colour.
    for (int step = 0; step < 7; ++step) {
      const int left = kLeft - 2 - step, right = kLeft + kWidth + 1 + step;
      EXPECT_EQ(height_of(image, left, low), open.low ? 16 - 2 * step : 0) << step;
      EXPECT_EQ(height_of(image, right, high), open.high ? 16 - 2 * step : 0) << step;
    }
    EXPECT_EQ(image.at(kLeft - 12, kTop + 7), kWhite);
    EXPECT_EQ(image.at(kLeft + kWidth + 11, kTop + 7), kWhite);
  }
}

}  // namespace
}  // namespace lamella
