#include "compare/drawing/canvas.h"

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <cairo.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "compare/drawing/printable_text.h"

namespace lamella {
namespace {

// Of vector pictures: enough for paper.
constexpr int kRasterScale = 4;

struct Release {
  void operator()(cairo_t* c) const { cairo_destroy(c); }
  void operator()(cairo_surface_t* s) const { cairo_surface_destroy(s); }
  void operator()(cairo_font_options_t* o) const { cairo_font_options_destroy(o); }
};
using Context = std::unique_ptr<cairo_t, Release>;
using Surface = std::unique_ptr<cairo_surface_t, Release>;

void check(cairo_status_t status) {
  if (status != CAIRO_STATUS_SUCCESS)
    throw PictureError(std::string("a picture cannot be drawn: ") + cairo_status_to_string(status));
}

cairo_status_t append(void* bytes, const unsigned char* data, unsigned int length) {
  static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), length);
  return CAIRO_STATUS_SUCCESS;
}

Surface surface_of(PictureFormat format, int width, int height, std::string& bytes) {
  Surface surface;
  switch (format) {
    case PictureFormat::svg:
      surface.reset(cairo_svg_surface_create_for_stream(append, &bytes, width, height));
      break;
    case PictureFormat::pdf:
      surface.reset(cairo_pdf_surface_create_for_stream(append, &bytes, width, height));
      break;
    case PictureFormat::png:
      surface.reset(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height));
      break;
  }
  check(cairo_surface_status(surface.get()));
  // No date, so that equal pictures are equal files: what is no date leaves the entry out.
  if (format == PictureFormat::pdf)
    cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_CREATE_DATE, "none");
  return surface;
}

/// The same shapes and advances in every format: no hinting.
void choose_font(cairo_t* c, Font font) {
  const std::unique_ptr<cairo_font_options_t, Release> options(cairo_font_options_create());
  cairo_font_options_set_antialias(options.get(), CAIRO_ANTIALIAS_GRAY);
  cairo_font_options_set_hint_style(options.get(), CAIRO_HINT_STYLE_NONE);
  cairo_font_options_set_hint_metrics(options.get(), CAIRO_HINT_METRICS_OFF);
  cairo_set_font_options(c, options.get());
  cairo_select_font_face(c, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                         font == Font::small ? CAIRO_FONT_WEIGHT_NORMAL : CAIRO_FONT_WEIGHT_BOLD);
  cairo_set_font_size(c, font == Font::title ? 14 : 11);
}

double width_of(cairo_t* c, const std::string& text) {
  cairo_text_extents_t extents;
  cairo_text_extents(c, text.c_str(), &extents);
  check(cairo_status(c));
  return extents.x_advance;
}

/// From the top of a line to its letters' foot.
double ascent_of(cairo_t* c) {
  cairo_font_extents_t extents;
  cairo_font_extents(c, &extents);
  return extents.ascent;
}

void choose_color(cairo_t* c, Color color) {
  cairo_set_source_rgb(c, color.r / 255.0, color.g / 255.0, color.b / 255.0);
}

/// Cairo names surfaces and images by how many the process has made: here they are counted within
/// the picture, so that equal pictures are equal files.
std::string with_counted_names(const std::string& svg) {
  std::map<std::string, std::string> names;
  std::string out;
  std::size_t from = 0;
  for (const std::string_view kind : {"surface", "image"}) {
    int count = 0;
    const std::string mark = fmt::format("id=\"{}", kind);
    for (std::size_t at = svg.find(mark); at != std::string::npos; at = svg.find(mark, at + 1)) {
      const std::size_t begin = at + 4, end = svg.find('"', begin);
      names[svg.substr(begin, end - begin)] = fmt::format("{}{}", kind, count++);
    }
  }
  // Names stand in quotes, or behind # where they are referred to.
  for (std::size_t at = svg.find_first_of("\"#"); at != std::string::npos;
       at = svg.find_first_of("\"#", at + 1)) {
    const std::size_t end = svg.find_first_of("\")#", at + 1);
    if (end == std::string::npos || end - at > 24) continue;
    const auto found = names.find(svg.substr(at + 1, end - at - 1));
    if (found == names.end()) continue;
    out.append(svg, from, at + 1 - from).append(found->second);
    from = end;
  }
  return out.append(svg, from);
}

}  // namespace

struct Canvas::Drawing {
  PictureFormat format;
  std::string bytes;  // before the surface, which writes into it to its end
  Surface surface;
  Context context;
  int width, height;
};

bool Canvas::is_available() { return true; }
void Canvas::require_available() {}

Canvas::Canvas(int width, int height, PictureFormat format) : drawing_(new Drawing{}) {
  Drawing& d = *drawing_;
  d.format = format;
  d.width = width;
  d.height = height;
  d.surface = surface_of(format, width, height, d.bytes);
  d.context.reset(cairo_create(d.surface.get()));
  check(cairo_status(d.context.get()));
  fill(0, 0, width, height, {255, 255, 255});
}

Canvas::~Canvas() = default;
Canvas::Canvas(Canvas&&) noexcept = default;
Canvas& Canvas::operator=(Canvas&&) noexcept = default;

void Canvas::fill(double x, double y, double width, double height, Color color) {
  cairo_t* c = drawing_->context.get();
  choose_color(c, color);
  cairo_rectangle(c, x, y, width, height);
  cairo_fill(c);
}

void Canvas::outline(int x, int y, int width, int height, Color color) {
  cairo_t* c = drawing_->context.get();
  choose_color(c, color);
  cairo_set_line_width(c, 1);
  cairo_rectangle(c, x + 0.5, y + 0.5, width - 1, height - 1);
  cairo_stroke(c);
}

void Canvas::ring(double x, double y, double inner, double outer, Color color) {
  cairo_t* c = drawing_->context.get();
  choose_color(c, color);
  cairo_new_path(c);
  if (inner <= 0) {
    cairo_arc(c, x, y, outer, 0, 2 * std::numbers::pi);
    cairo_fill(c);
    return;
  }
  cairo_set_line_width(c, outer - inner);
  cairo_arc(c, x, y, (inner + outer) / 2, 0, 2 * std::numbers::pi);
  cairo_close_path(c);
  cairo_stroke(c);
}

void Canvas::line(double x0, double y0, double x1, double y1, double width, Color color) {
  cairo_t* c = drawing_->context.get();
  choose_color(c, color);
  cairo_set_line_width(c, width);
  cairo_set_line_cap(c, CAIRO_LINE_CAP_ROUND);
  cairo_move_to(c, x0, y0);
  cairo_line_to(c, x1, y1);
  cairo_stroke(c);
  cairo_set_line_cap(c, CAIRO_LINE_CAP_BUTT);
}

void Canvas::cross(double x, double y, double arm, double stroke, Color color) {
  line(x - arm, y - arm, x + arm, y + arm, stroke, color);
  line(x - arm, y + arm, x + arm, y - arm, stroke, color);
}

int Canvas::raster_scale() const {
  return drawing_->format == PictureFormat::png ? 1 : kRasterScale;
}

void Canvas::paint(const Raster& raster, double x, double y, double width, double height) {
  const Surface image(
      cairo_image_surface_create(CAIRO_FORMAT_ARGB32, raster.width(), raster.height()));
  check(cairo_surface_status(image.get()));
  cairo_surface_flush(image.get());
  unsigned char* data = cairo_image_surface_get_data(image.get());
  const int stride = cairo_image_surface_get_stride(image.get());
  for (int row = 0; row < raster.height(); ++row) {
    const auto from = raster.pixels().subspan(
        static_cast<std::size_t>(row) * static_cast<std::size_t>(raster.width()),
        static_cast<std::size_t>(raster.width()));
    std::copy(from.begin(), from.end(),
              reinterpret_cast<std::uint32_t*>(data + static_cast<std::ptrdiff_t>(row) * stride));
  }
  cairo_surface_mark_dirty(image.get());
  cairo_t* c = drawing_->context.get();
  cairo_save(c);
  cairo_translate(c, x, y);
  cairo_scale(c, width / raster.width(), height / raster.height());
  cairo_set_source_surface(c, image.get(), 0, 0);
  cairo_pattern_set_filter(cairo_get_source(c), CAIRO_FILTER_NEAREST);
  cairo_rectangle(c, 0, 0, raster.width(), raster.height());
  cairo_fill(c);
  cairo_restore(c);
}

void Canvas::text(double x, double y, std::string_view utf8, Font font, Align align, Color color) {
  cairo_t* c = drawing_->context.get();
  const std::string line = printable_text(utf8);
  choose_font(c, font);
  choose_color(c, color);
  if (align == Align::center) x -= width_of(c, line) / 2;
  if (align == Align::right) x -= width_of(c, line);
  cairo_move_to(c, x, y + ascent_of(c));
  cairo_show_text(c, line.c_str());
  cairo_new_path(c);
}

void Canvas::text_upwards(double x, double y, std::string_view utf8, Font font, Color color) {
  cairo_t* c = drawing_->context.get();
  const std::string line = printable_text(utf8);
  choose_font(c, font);
  choose_color(c, color);
  cairo_save(c);
  cairo_translate(c, x + ascent_of(c), y + width_of(c, line) / 2);
  cairo_rotate(c, -std::numbers::pi / 2);
  cairo_move_to(c, 0, 0);
  cairo_show_text(c, line.c_str());
  cairo_new_path(c);
  cairo_restore(c);
}

std::string Canvas::bytes() {
  Drawing& d = *drawing_;
  check(cairo_status(d.context.get()));
  if (d.format == PictureFormat::png) {
    cairo_surface_flush(d.surface.get());
    check(cairo_surface_write_to_png_stream(d.surface.get(), append, &d.bytes));
  } else {
    cairo_show_page(d.context.get());
    cairo_surface_finish(d.surface.get());
    check(cairo_surface_status(d.surface.get()));
  }
  return d.format == PictureFormat::svg ? with_counted_names(d.bytes) : std::move(d.bytes);
}

int text_width(std::string_view utf8, Font font) {
  // Nothing is drawn on it: a surface that text is measured with.
  const Surface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, 1, 1));
  const Context c(cairo_create(surface.get()));
  choose_font(c.get(), font);
  return static_cast<int>(std::ceil(width_of(c.get(), printable_text(utf8))));
}

}  // namespace lamella
