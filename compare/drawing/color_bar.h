#pragma once

#include "compare/drawing/canvas.h"
#include "compare/drawing/color_scale.h"

namespace lamella {

/// Pixels from the top of a bar to below the numbers under it.
inline constexpr int kColorBarHeight = 36;

/// Beyond which ends of a scale there are values, which have the colours of the ends.
struct OpenEnds {
  bool low = false, high = false;
};

/// A horizontal bar of the scale's colours, low on the left, with as many numbers as fit. Arrow
/// heads at the open ends.
void draw_color_bar(Canvas& canvas, const ColorScale& scale, int left, int top, int width,
                    OpenEnds open);

}  // namespace lamella
