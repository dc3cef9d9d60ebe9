#include "compare/command/picture_options.h"

#include "compare/drawing/canvas.h"

namespace lamella {

std::vector<PictureFormat> picture_formats_of(const std::vector<std::string>& names) {
  if (!names.empty()) {
    Canvas::require_available();
    return picture_formats(names);
  }
  if (!Canvas::is_available()) return {};
  return {PictureFormat::png};
}

std::string endings_text(const std::vector<PictureFormat>& formats) {
  std::string text;
  for (const PictureFormat format : formats)
    text += (text.empty() ? "*." : ", *.") + to_text(format);
  return text;
}

std::string absent_pictures_text() {
  return Canvas::is_available()
             ? ""
             : "no pictures: this lamella was built without Cairo (-DLAMELLA_CAIRO=OFF)\n";
}

}  // namespace lamella
