#pragma once

#include <cairo.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

#include "compare/drawing/color_map.h"

namespace lamella {

/// The pixels of a PNG, read by Cairo.
class Decoded {
 public:
  explicit Decoded(std::string_view png)
      : image_(cairo_image_surface_create_from_png_stream(read, &png), cairo_surface_destroy) {
    if (cairo_surface_status(image_.get()) != CAIRO_STATUS_SUCCESS)
      throw std::runtime_error("no PNG");
  }
  [[nodiscard]] int width() const { return cairo_image_surface_get_width(image_.get()); }
  [[nodiscard]] int height() const { return cairo_image_surface_get_height(image_.get()); }
  [[nodiscard]] Color at(int x, int y) const {
    const unsigned char* row = cairo_image_surface_get_data(image_.get()) +
                               std::ptrdiff_t{y} * cairo_image_surface_get_stride(image_.get());
    std::uint32_t pixel = 0;
    std::memcpy(&pixel, row + std::ptrdiff_t{x} * 4, 4);
    return {static_cast<std::uint8_t>(pixel >> 16), static_cast<std::uint8_t>(pixel >> 8),
            static_cast<std::uint8_t>(pixel)};
  }

 private:
  static cairo_status_t read(void* rest, unsigned char* data, unsigned int length) {
    auto& bytes = *static_cast<std::string_view*>(rest);
    if (bytes.size() < length) return CAIRO_STATUS_READ_ERROR;
    std::copy_n(bytes.begin(), length, data);
    bytes.remove_prefix(length);
    return CAIRO_STATUS_SUCCESS;
  }

  std::unique_ptr<cairo_surface_t, void (*)(cairo_surface_t*)> image_;
};

}  // namespace lamella
