#pragma once

#include <functional>
#include <string>
#include <vector>

namespace lamella {

/// Pixels, or a drawing that stays sharp at any size.
enum class PictureFormat { png, svg, pdf };

/// The ending of its files, without the dot: "png".
[[nodiscard]] std::string to_text(PictureFormat format);
[[nodiscard]] const std::vector<std::string>& picture_format_names();
/// The formats of these names, each once, in the order given. Throws std::invalid_argument for
/// other names.
[[nodiscard]] std::vector<PictureFormat> picture_formats(const std::vector<std::string>& names);

/// Writes a picture as `stem`.png, .svg, .pdf, and returns the paths. `draw`: the bytes of a
/// format. Throws OutputError.
std::vector<std::string> write_pictures(const std::string& stem,
                                        const std::vector<PictureFormat>& formats,
                                        const std::function<std::string(PictureFormat)>& draw);

}  // namespace lamella
