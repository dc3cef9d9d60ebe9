#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "compare/drawing/canvas.h"

namespace lamella {

/// Of a line, in pixels.
[[nodiscard]] int text_height(Font font);
/// Breaks a text at spaces into lines of at most `width` pixels; longer words are cut.
[[nodiscard]] std::vector<std::string> wrapped(std::string_view utf8, Font font, int width);
/// The text, or its beginning and an ellipsis where it is wider than `width` pixels.
[[nodiscard]] std::string shortened(std::string_view utf8, Font font, int width);

}  // namespace lamella
