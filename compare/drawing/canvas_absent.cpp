// Stands in for canvas.cpp where there is no Cairo.
#include "compare/drawing/canvas.h"

namespace lamella {

struct Canvas::Drawing {};

bool Canvas::is_available() { return false; }

void Canvas::require_available() {
  throw PictureError(
      "pictures need Cairo, and this lamella was built without (-DLAMELLA_CAIRO=OFF); allowed: "
      "the answer's other files, or a build with libcairo2-dev and -DLAMELLA_CAIRO=ON");
}

Canvas::Canvas(int, int, PictureFormat) { require_available(); }
Canvas::~Canvas() = default;
Canvas::Canvas(Canvas&&) noexcept = default;
Canvas& Canvas::operator=(Canvas&&) noexcept = default;
void Canvas::fill(double, double, double, double, Color) {}
void Canvas::outline(int, int, int, int, Color) {}
void Canvas::ring(double, double, double, double, Color) {}
void Canvas::line(double, double, double, double, double, Color) {}
void Canvas::cross(double, double, double, double, Color) {}
int Canvas::raster_scale() const { return 1; }
void Canvas::paint(const Raster&, double, double, double, double) {}
void Canvas::text(double, double, std::string_view, Font, Align, Color) {}
void Canvas::text_upwards(double, double, std::string_view, Font, Color) {}
std::string Canvas::bytes() { return {}; }
int text_width(std::string_view, Font) {
  Canvas::require_available();
  return 0;
}

}  // namespace lamella
