#pragma once

#include "compare/drawing/canvas.h"
#include "compare/drawing/color_scale.h"

namespace lamella {

/// Pixels from the top of a bar to below the numbers under it.
inline constexpr int kColorBarHeight = 36;

/// A horizontal bar of the scale's colours, low on the left, with as many numbers as fit.
/// open_ended: arrow heads say that values beyond the ends have the colours of the ends.
void draw_color_bar(Canvas& canvas, const ColorScale& scale, int left, int top, int width,
                    bool open_ended);

}  // namespace lamella
