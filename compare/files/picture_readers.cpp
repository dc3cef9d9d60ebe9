// The only source that includes libpng and libjpeg. Both leave their functions by longjmp, so what
// they fill lives outside of the functions that call setjmp.
#include <fmt/format.h>
// libjpeg's header wants FILE and size_t before it.
#include <cstdio>
// clang-format off
#include <jpeglib.h>
// clang-format on
#include <png.h>

#include <csetjmp>
#include <cstring>

#include "compare/files/output_error.h"
#include "compare/files/picture_file.h"

namespace lamella {
namespace {

constexpr std::size_t kMessageBytes = 200;

void keep_message(char* to, const char* message) {
  std::strncpy(to, message, kMessageBytes - 1);
  to[kMessageBytes - 1] = '\0';
  for (char* c = to; *c; ++c)
    if (*c < ' ' && *c >= 0) *c = ' ';
}

[[noreturn]] void refuse(const std::filesystem::path& name, const char* why) {
  throw OutputError(fmt::format("cannot read {}: {}", name.string(), why));
}

// Most bytes of a PNG's pixels per byte of the file: deflate's limit, 1032. Most pixels of a JPEG
// per byte: 512 in blocks of one bit each. A header that claims more is not believed, so that a
// small file asks for little memory.
constexpr std::size_t kMostInflation = 2048, kSmallPicture = 1 << 20;

struct PngSource {
  std::string_view left;
  char message[kMessageBytes] = "";
};

void png_failed(png_structp png, png_const_charp message) {
  keep_message(static_cast<PngSource*>(png_get_error_ptr(png))->message, message);
  png_longjmp(png, 1);
}

void png_warned(png_structp, png_const_charp) {}

void png_bytes(png_structp png, png_bytep to, std::size_t count) {
  auto& source = *static_cast<PngSource*>(png_get_io_ptr(png));
  if (count > source.left.size()) png_error(png, "it ends early");
  std::memcpy(to, source.left.data(), count);
  source.left.remove_prefix(count);
}

struct PngState {
  png_structp png = nullptr;
  png_infop info = nullptr;
  ~PngState() { png_destroy_read_struct(&png, &info, nullptr); }
};

// Each step false where libpng jumped out of it.
bool read_png_header(PngState& state) {
  if (setjmp(png_jmpbuf(state.png))) return false;
  png_read_info(state.png, state.info);
  return true;
}

bool read_png_rows(PngState& state, png_bytep* rows) {
  if (setjmp(png_jmpbuf(state.png))) return false;
  png_read_image(state.png, rows);
  return true;
}

bool ask_png_for_samples(PngState& state) {
  if (setjmp(png_jmpbuf(state.png))) return false;
  if (png_get_color_type(state.png, state.info) == PNG_COLOR_TYPE_PALETTE)
    png_set_palette_to_rgb(state.png);
  if (png_get_color_type(state.png, state.info) == PNG_COLOR_TYPE_GRAY &&
      png_get_bit_depth(state.png, state.info) < 8)
    png_set_expand_gray_1_2_4_to_8(state.png);
  if (png_get_valid(state.png, state.info, PNG_INFO_tRNS)) png_set_tRNS_to_alpha(state.png);
  png_set_interlace_handling(state.png);
  png_read_update_info(state.png, state.info);
  return true;
}

struct JpegErrors {
  jpeg_error_mgr manager;  // the first member: libjpeg knows its address
  std::jmp_buf back;
  char message[kMessageBytes];
};

void jpeg_failed(j_common_ptr jpeg) {
  char text[JMSG_LENGTH_MAX];
  (*jpeg->err->format_message)(jpeg, text);
  auto* errors = reinterpret_cast<JpegErrors*>(jpeg->err);
  keep_message(errors->message, text);
  std::longjmp(errors->back, 1);
}

void jpeg_warned(j_common_ptr jpeg, int level) {
  // A damaged picture, which libjpeg would go on with.
  if (level < 0) jpeg_failed(jpeg);
}

// Progressive files of endless scans would take hours.
void jpeg_scans(j_common_ptr jpeg) {
  constexpr int kMostScans = 500;
  auto* reading = reinterpret_cast<j_decompress_ptr>(jpeg);
  if (reading->input_scan_number <= kMostScans) return;
  auto* errors = reinterpret_cast<JpegErrors*>(jpeg->err);
  keep_message(errors->message, "it has more than 500 scans");
  std::longjmp(errors->back, 1);
}

struct JpegState {
  jpeg_decompress_struct jpeg{};
  JpegErrors errors{};
  jpeg_progress_mgr progress{};
  float* out = nullptr;  // where the next number goes; not of a function that calls setjmp

  JpegState() {
    jpeg.err = jpeg_std_error(&errors.manager);
    errors.manager.error_exit = jpeg_failed;
    errors.manager.emit_message = jpeg_warned;
    progress.progress_monitor = jpeg_scans;
  }
  ~JpegState() { jpeg_destroy_decompress(&jpeg); }
  JpegState(const JpegState&) = delete;
  JpegState& operator=(const JpegState&) = delete;
};

bool read_jpeg_header(JpegState& state, const unsigned char* bytes, unsigned long size) {
  if (setjmp(state.errors.back)) return false;
  jpeg_create_decompress(&state.jpeg);
  state.jpeg.progress = &state.progress;
  jpeg_mem_src(&state.jpeg, bytes, size);
  jpeg_read_header(&state.jpeg, TRUE);
  state.jpeg.out_color_space = state.jpeg.num_components == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_calc_output_dimensions(&state.jpeg);
  return true;
}

void take_jpeg_row(JpegState& state, const unsigned char* row) {
  const std::size_t count = static_cast<std::size_t>(state.jpeg.output_width) *
                            static_cast<std::size_t>(state.jpeg.output_components);
  for (std::size_t k = 0; k < count; ++k) *state.out++ = static_cast<float>(row[k]) / 255.F;
}

bool read_jpeg_rows(JpegState& state, unsigned char* row) {
  if (setjmp(state.errors.back)) return false;
  jpeg_start_decompress(&state.jpeg);
  while (state.jpeg.output_scanline < state.jpeg.output_height) {
    jpeg_read_scanlines(&state.jpeg, &row, 1);
    take_jpeg_row(state, row);
  }
  jpeg_finish_decompress(&state.jpeg);
  return true;
}

}  // namespace

bool has_png_and_jpeg() { return true; }

Picture read_png(std::string_view bytes, const std::filesystem::path& name) {
  PngSource source{bytes};
  PngState state;
  state.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &source, png_failed, png_warned);
  state.info = state.png ? png_create_info_struct(state.png) : nullptr;
  if (!state.info) refuse(name, "libpng has no memory");
  png_set_read_fn(state.png, &source, png_bytes);
  if (!read_png_header(state)) refuse(name, source.message);
  check_picture_size(png_get_image_width(state.png, state.info),
                     png_get_image_height(state.png, state.info), 4, name);
  // Before palettes are expanded, by 3 or 4.
  if (png_get_rowbytes(state.png, state.info) * png_get_image_height(state.png, state.info) >
      kSmallPicture + kMostInflation * bytes.size())
    refuse(name, "it ends early");
  if (!ask_png_for_samples(state)) refuse(name, source.message);
  Picture picture;
  picture.integer = true;
  picture.width = static_cast<int>(png_get_image_width(state.png, state.info));
  picture.height = static_cast<int>(png_get_image_height(state.png, state.info));
  picture.channels = png_get_channels(state.png, state.info);
  const bool wide = png_get_bit_depth(state.png, state.info) == 16;
  const std::size_t row_bytes = png_get_rowbytes(state.png, state.info);
  const auto height = static_cast<std::size_t>(picture.height);
  std::vector<unsigned char> samples(row_bytes * height);
  std::vector<png_bytep> rows(height);
  for (std::size_t y = 0; y < height; ++y) rows[y] = samples.data() + y * row_bytes;
  if (!read_png_rows(state, rows.data())) refuse(name, source.message);
  picture.values.resize(static_cast<std::size_t>(picture.width) * height *
                        static_cast<std::size_t>(picture.channels));
  for (std::size_t k = 0; k < picture.values.size(); ++k)
    picture.values[k] =
        wide ? static_cast<float>(256 * samples[2 * k] + samples[2 * k + 1]) / 65535.F
             : static_cast<float>(samples[k]) / 255.F;
  return picture;
}

Picture read_jpeg(std::string_view bytes, const std::filesystem::path& name) {
  JpegState state;
  if (!read_jpeg_header(state, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()))
    refuse(name, state.errors.message);
  Picture picture;
  picture.integer = true;
  picture.channels = state.jpeg.out_color_space == JCS_GRAYSCALE ? 1 : 3;
  check_picture_size(state.jpeg.output_width, state.jpeg.output_height, picture.channels, name);
  if (static_cast<std::size_t>(state.jpeg.output_width) * state.jpeg.output_height >
      kSmallPicture + kMostInflation * bytes.size())
    refuse(name, "it ends early");
  picture.width = static_cast<int>(state.jpeg.output_width);
  picture.height = static_cast<int>(state.jpeg.output_height);
  const std::size_t row =
      static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.channels);
  picture.values.resize(row * static_cast<std::size_t>(picture.height));
  std::vector<unsigned char> samples(row);
  state.out = picture.values.data();
  if (!read_jpeg_rows(state, samples.data())) refuse(name, state.errors.message);
  return picture;
}

}  // namespace lamella
