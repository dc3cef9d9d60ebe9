#pragma once

#include <string>
#include <vector>

#include "compare/drawing/picture_format.h"

namespace lamella {

/// The formats of these names, as --pictures takes them; of no names: PNG, or none in a build
/// without Cairo. Throws PictureError where a build without Cairo is asked for some.
[[nodiscard]] std::vector<PictureFormat> picture_formats_of(const std::vector<std::string>& names);

/// "*.png, *.svg"
[[nodiscard]] std::string endings_text(const std::vector<PictureFormat>& formats);

/// One line for the user where a build without Cairo leaves pictures out; else empty.
[[nodiscard]] std::string absent_pictures_text();

}  // namespace lamella
