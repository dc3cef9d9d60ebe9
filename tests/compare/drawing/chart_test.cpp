#include "compare/drawing/chart.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <set>

#include "compare/drawing/picture_text.h"
#include "compare/drawing/printable_text.h"
#include "tests/compare/drawing/decoded_png.h"

namespace lamella {
namespace {

/// Pairs of a line and its dots.
Chart pairs(int count) {
  Chart chart{.title = "pairs", .subtitle = "", .x_label = "x", .y_label = "y", .series = {}};
  for (int k = 0; k < count; ++k) {
    chart.series.push_back({.label = std::to_string(k), .x = {0, 1}, .y = {1.0 * k, 1.0 * k}});
    chart.series.push_back(
        {.label = "", .x = {0.5}, .y = {k + 0.5}, .dots = true, .same_color = true});
  }
  return chart;
}

/// Pixels that a colour covers for the most part: edges are mixed with what is behind them.
int pixels_of(const Decoded& image, Color color) {
  const auto near = [](int a, int b) { return std::abs(a - b) < 48; };
  int count = 0;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      const Color c = image.at(x, y);
      count += near(c.r, color.r) && near(c.g, color.g) && near(c.b, color.b);
    }
  return count;
}

TEST(Chart, GivesALineAndItsDotsOneColourAndOtherSeriesOthers) {
  const Chart chart = pairs(9);
  const std::vector<Color> colors = series_colors(chart);
  ASSERT_EQ(colors.size(), 18U);
  std::set<std::array<int, 3>> different;
  for (std::size_t k = 0; k < colors.size(); k += 2) {
    EXPECT_EQ(colors[k], colors[k + 1]) << k;
    different.insert({colors[k].r, colors[k].g, colors[k].b});
  }
  EXPECT_EQ(different.size(), 9U);
}

TEST(Chart, DrawsASeriesInItsColour) {
  const Chart both = pairs(1);
  Chart line = both;
  line.series.pop_back();
  const Color color = series_colors(both)[0];
  const Decoded with(draw_chart(both)), without(draw_chart(line));
  // A line across the plot, and a dot of 5 pixels in it and in the legend.
  EXPECT_GT(pixels_of(without, color), 400);
  EXPECT_GT(pixels_of(with, color), pixels_of(without, color) + 20);
  EXPECT_EQ(pixels_of(with, series_colors(pairs(2))[2]), 0);
}

TEST(Chart, WithALogarithmicAxisPutsValuesWhereTheirLogarithmsWouldBe) {
  Chart linear{.title = "x", .subtitle = "", .x_label = "x", .y_label = "y", .series = {}};
  linear.series.push_back({.label = "a", .x = {0, 1, 2}, .y = {-1, 0.5, 2}});
  linear.from_zero = false;
  Chart logarithmic = linear;
  for (double& y : logarithmic.series[0].y) y = std::pow(10, y);
  // Values without a logarithm are left out.
  logarithmic.series[0].x.push_back(2);
  logarithmic.series[0].y.push_back(0);
  logarithmic.log_y = true;
  const Decoded a(draw_chart(linear)), b(draw_chart(logarithmic));
  const Color color = series_colors(linear)[0];
  const int pixels = pixels_of(a, color);
  EXPECT_GT(pixels, 300);
  EXPECT_EQ(pixels_of(b, color), pixels);
}

TEST(Chart, IsWrittenAsPngSvgOrPdfWithEqualBytesForEqualCharts) {
  const std::vector<std::pair<PictureFormat, std::string>> starts = {
      {PictureFormat::png, "\x89PNG\r\n\x1a\n"},
      {PictureFormat::svg, "<?xml"},
      {PictureFormat::pdf, "%PDF-1."}};
  for (const auto& [format, start] : starts) {
    const std::string bytes = draw_chart(pairs(3), format);
    EXPECT_EQ(bytes.substr(0, start.size()), start);
    EXPECT_EQ(bytes, draw_chart(pairs(3), format)) << to_text(format);
    EXPECT_NE(bytes, draw_chart(pairs(2), format)) << to_text(format);
    // A moment of the clock would make every run's file another.
    EXPECT_EQ(bytes.find("CreationDate"), std::string::npos);
  }
}

TEST(Text, HasGreekLettersWhichDifferFromEachOtherAndAreAntiAliased) {
  std::set<std::string> pictures;
  const std::vector<std::string> letters = {"\u03b8", "\u03c6", "\u03bc", "\u03c4", "\u03b1",
                                            "\u03b2", "\u03c1", "\u03c0", "\u221e", "\u00b0",
                                            "\u207b", "\u2212", "?",      "\ufffd"};
  for (const std::string& letter : letters) {
    Canvas canvas(20, 20);
    canvas.text(4, 2, letter, Font::small, Align::left, {0, 0, 0});
    const std::string png = canvas.bytes();
    pictures.insert(png);
    const Decoded image(png);
    int grey = 0;
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 20; ++x) {
        const Color c = image.at(x, y);
        EXPECT_TRUE(c.r == c.g && c.g == c.b);
        grey += c.r > 32 && c.r < 224;
      }
    EXPECT_GT(grey, 0) << letter;
  }
  EXPECT_EQ(pictures.size(), letters.size());
}

TEST(Text, IsMeasuredBrokenAndCutWhereCharactersEnd) {
  EXPECT_GT(text_width("\u03b8\u03b8", Font::small), text_width("\u03b8", Font::small));
  for (const std::string& line : wrapped("one two three four five six seven", Font::small, 60))
    EXPECT_LE(text_width(line, Font::small), 60);
  for (int width = 10; width < 80; ++width) {
    const std::string cut = shortened(
        "\u03b1\u03b2\u03b3\u03b4\u03b5\u03b6\u03b7\u03b8\u03b9\u03ba\u03bb", Font::bold, width);
    EXPECT_LE(text_width(cut, Font::bold), std::max(width, text_width("\u2026", Font::bold)));
    EXPECT_EQ(printable_text(cut), cut) << "no half of a character";
  }
  EXPECT_EQ(printable_text("a\n\xff"
                           "b\xc2"),
            "a \ufffd"
            "b\ufffd");
}

TEST(PictureFormats, AreTakenByNameAndOthersRefused) {
  EXPECT_EQ(picture_formats({"pdf", "png", "pdf"}),
            (std::vector<PictureFormat>{PictureFormat::pdf, PictureFormat::png}));
  EXPECT_THROW((void)picture_formats({"gif"}), std::invalid_argument);
}

}  // namespace
}  // namespace lamella
