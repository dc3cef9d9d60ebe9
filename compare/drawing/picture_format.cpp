#include "compare/drawing/picture_format.h"

#include <algorithm>
#include <stdexcept>

#include "compare/files/output_folder.h"

namespace lamella {

const std::vector<std::string>& picture_format_names() {
  static const std::vector<std::string> names{"png", "svg", "pdf"};
  return names;
}

std::string to_text(PictureFormat format) {
  return picture_format_names()[static_cast<std::size_t>(format)];
}

std::vector<PictureFormat> picture_formats(const std::vector<std::string>& names) {
  const std::vector<std::string>& known = picture_format_names();
  std::vector<PictureFormat> formats;
  for (const std::string& name : names) {
    const auto found = std::find(known.begin(), known.end(), name);
    if (found == known.end()) throw std::invalid_argument("no format of pictures: " + name);
    const auto format = static_cast<PictureFormat>(found - known.begin());
    if (std::find(formats.begin(), formats.end(), format) == formats.end())
      formats.push_back(format);
  }
  return formats;
}

std::vector<std::string> write_pictures(const std::string& stem,
                                        const std::vector<PictureFormat>& formats,
                                        const std::function<std::string(PictureFormat)>& draw) {
  std::vector<std::string> paths;
  for (const PictureFormat format : formats) {
    paths.push_back(stem + "." + to_text(format));
    write_file(paths.back(), draw(format));
  }
  return paths;
}

}  // namespace lamella
