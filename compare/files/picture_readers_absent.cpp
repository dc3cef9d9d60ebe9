// Stands in for picture_readers.cpp where there is no libpng and no libjpeg.
#include <fmt/format.h>

#include "compare/files/output_error.h"
#include "compare/files/picture_file.h"

namespace lamella {
namespace {

[[noreturn]] void refuse_picture(const std::filesystem::path& name, const char* format) {
  throw OutputError(
      fmt::format("cannot read {}: found {}, and this lamella was built without libpng and libjpeg "
                  "(-DLAMELLA_PICTURES=OFF); allowed: OpenEXR",
                  name.string(), format));
}

}  // namespace

bool has_png_and_jpeg() { return false; }

Picture read_png(std::string_view, const std::filesystem::path& name) {
  refuse_picture(name, "PNG");
}

Picture read_jpeg(std::string_view, const std::filesystem::path& name) {
  refuse_picture(name, "JPEG");
}

}  // namespace lamella
