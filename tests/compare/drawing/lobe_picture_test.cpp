#include "compare/drawing/lobe_picture.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "compare/drawing/color_map.h"
#include "compare/files/output_folder.h"
#include "tests/compare/drawing/decoded_png.h"
#include "tests/compare/files/temporary_folder.h"

namespace lamella {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr int kPanel = PictureLayout::kPanel;
constexpr Color kWhite{255, 255, 255};

/// 4 x 8 cells; truth rises from 0 to 1 with the cell's index.
LobePicture example(bool folded) {
  LobePicture picture;
  picture.grid = {.mu_cells = 4, .phi_cells = 8, .folded = folded};
  const int cells = picture.grid.cells();
  for (int i = 0; i < cells; ++i) {
    const double t = static_cast<double>(i) / (cells - 1);
    picture.truth.push_back(t);
    picture.model.push_back(0.6 * t);
    picture.difference.push_back(-0.4 * t);
    picture.z.push_back(i == 0 ? -9 : i == 1 ? 9 : 0);
  }
  picture.title = "example";
  picture.mu_i = 0.9;
  return picture;
}

/// Pixel of a disc at the middle of a cell's area.
std::pair<int, int> disc_pixel(const LobePicture& picture, int panel, int row, double phi) {
  const double radius = std::sqrt((row + 0.5) / picture.grid.mu_cells) * kPanel / 2;
  return {PictureLayout::panel_left(panel) + kPanel / 2 +
              static_cast<int>(std::floor(radius * std::cos(phi))),
          layout_of(picture).disc_top + kPanel / 2 -
              static_cast<int>(std::ceil(radius * std::sin(phi)))};
}

TEST(Picture, IsAPngOfTheSizeThatItsLayoutSays) {
  const LobePicture picture = example(false);
  const std::string png = draw_lobe(picture);
  EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
  const Decoded image(png);
  const PictureLayout layout = layout_of(picture);
  EXPECT_EQ(layout.panels, 4);
  EXPECT_EQ(image.width(), layout.width);
  EXPECT_EQ(image.height(), layout.height);
  EXPECT_EQ(image.at(0, 0), kWhite);
  EXPECT_EQ(image.at(layout.width - 1, layout.height - 1), kWhite);
}

TEST(Picture, OfEqualInputIsEqualByteForByteInEveryFormat) {
  for (const PictureFormat format : picture_formats(picture_format_names())) {
    const std::string bytes = draw_lobe(example(false), format);
    EXPECT_EQ(bytes, draw_lobe(example(false), format)) << to_text(format);
    EXPECT_NE(bytes, draw_lobe(example(true), format)) << to_text(format);
  }
}

TEST(Picture, ShowsEveryCellOfTheDiscInItsColour) {
  for (const bool folded : {false, true}) {
    const LobePicture picture = example(folded);
    const Decoded image(draw_lobe(picture));
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < 8; ++column) {
        const double phi = 2 * kPi * (column + 0.5) / 8;
        const double mu2 = 1 - (row + 0.5) / 4;
        const double t = picture.truth[static_cast<std::size_t>(picture.grid.cell(mu2, phi))];
        const auto [x, y] = disc_pixel(picture, 0, row, phi);
        EXPECT_EQ(image.at(x, y), viridis(t)) << folded << ' ' << row << ' ' << column;
        const auto [x1, y1] = disc_pixel(picture, 1, row, phi);
        EXPECT_EQ(image.at(x1, y1), viridis(0.6 * t)) << "the model shares the scale of the truth";
      }
  }
}

TEST(Picture, ShowsTheRectangleWithTheNormalAtTheTopAndPhiToTheRight) {
  for (const bool folded : {false, true}) {
    const LobePicture picture = example(folded);
    const Decoded image(draw_lobe(picture));
    const int columns = picture.grid.columns(), top = layout_of(picture).rectangle_top;
    for (int row = 0; row < 4; ++row)
      for (int column = 0; column < columns; ++column) {
        const int x = (2 * column + 1) * kPanel / (2 * columns);
        const int y = top + (2 * row + 1) * PictureLayout::kRectangle / 8;
        const double t = picture.truth[static_cast<std::size_t>(row * columns + column)];
        EXPECT_EQ(image.at(PictureLayout::panel_left(0) + x, y), viridis(t));
        // -0.4 is the end of the difference's own scale.
        EXPECT_EQ(image.at(PictureLayout::panel_left(2) + x, y), diverging_color(-t));
      }
  }
}

TEST(Picture, SaturatesZBeyondFour) {
  LobePicture picture = example(false);
  picture.z[2] = std::numeric_limits<double>::infinity();
  picture.z[3] = 2;
  const Decoded image(draw_lobe(picture));
  const int y = layout_of(picture).rectangle_top + 20;
  const auto color = [&](int column) {
    return image.at(PictureLayout::panel_left(3) + column * 32 + 16, y);
  };
  EXPECT_EQ(color(0), diverging_color(-1));
  EXPECT_EQ(color(1), diverging_color(1));
  EXPECT_EQ(color(2), diverging_color(1));
  EXPECT_EQ(color(3), diverging_color(0.5));
  EXPECT_EQ(color(4), diverging_color(0));
}

TEST(Picture, OfABoundedTruthShowsTheErrorOverItsBoundOnALogarithmicScale) {
  LobePicture picture = example(false);
  picture.bounded = true;
  // From a tenth of the bound to a million times it: seven decades.
  const double ratios[] = {0.1, 1, -10, 1e3, -1e6, 0, kNan};
  for (std::size_t k = 0; k < picture.z.size(); ++k) picture.z[k] = 0.01;
  for (int k = 0; k < 7; ++k) picture.z[k] = ratios[k];
  const Decoded image(draw_lobe(picture));
  const int y = layout_of(picture).rectangle_top + 20;
  const auto color = [&](int column) {
    return image.at(PictureLayout::panel_left(3) + column * 32 + 16, y);
  };
  const double places[] = {0, 1.0 / 7, 2.0 / 7, 4.0 / 7, 1, 0};
  for (int k = 0; k < 6; ++k) EXPECT_EQ(color(k), viridis(places[k])) << k;
  EXPECT_EQ(color(7), viridis(0));
  // What is far apart is told apart.
  EXPECT_NE(color(2), color(3));
  EXPECT_NE(color(3), color(4));
}

TEST(Picture, DrawsALogarithmicScaleWhenAsked) {
  LobePicture picture = example(false);
  for (double& v : picture.truth) v = 1e-4;
  picture.model = picture.truth;
  picture.truth[9] = 1;
  picture.truth[10] = 1e-2;
  picture.truth[11] = 0;
  picture.logarithmic = true;
  const Decoded image(draw_lobe(picture));
  const int y = layout_of(picture).rectangle_top + 60, left = PictureLayout::panel_left(0);
  EXPECT_EQ(image.at(left + 32 + 16, y), viridis(1));
  EXPECT_EQ(image.at(left + 64 + 16, y), viridis(0.5));
  EXPECT_EQ(image.at(left + 96 + 16, y), viridis(0));
}

TEST(Picture, HatchesCellsWithoutAValueInGreyAndSaysSo) {
  LobePicture picture = example(false);
  picture.truth[0] = kNan;
  const Decoded image(draw_lobe(picture));
  const int top = layout_of(picture).rectangle_top, left = PictureLayout::panel_left(0);
  bool light = false, dark = false;
  for (int x = left + 10; x < left + 30; ++x)
    for (int y = top + 10; y < top + 30; ++y) {
      const Color c = image.at(x, y);
      EXPECT_TRUE(c.r == c.g && c.g == c.b && c.r < 240) << x << ' ' << y;
      light = light || c.r > 200;
      dark = dark || c.r < 160;
    }
  EXPECT_TRUE(light && dark);
  EXPECT_NE(draw_lobe(picture), draw_lobe(example(false)));
}

TEST(Picture, MarksTheIncidentDirectionOnItsSideOrOppositeInTransmission) {
  LobePicture picture = example(false);
  const Decoded reflected(draw_lobe(picture));
  picture.transmitted = true;
  const Decoded transmitted(draw_lobe(picture));
  const int y = layout_of(picture).disc_top + kPanel / 2;
  const int middle = PictureLayout::panel_left(2) + kPanel / 2;
  const int radius = static_cast<int>(std::sqrt(1 - 0.81) * kPanel / 2);
  const auto is_dark = [](Color c) { return c.r + c.g + c.b < 120; };
  EXPECT_TRUE(is_dark(reflected.at(middle + radius, y - 5)));
  EXPECT_FALSE(is_dark(reflected.at(middle - radius, y - 5)));
  EXPECT_TRUE(is_dark(transmitted.at(middle - radius, y)));
  EXPECT_FALSE(is_dark(transmitted.at(middle + radius, y)));
}

TEST(Picture, LeavesOutThePanelsOfAbsentMaps) {
  LobePicture picture = example(false);
  picture.model.clear();
  picture.difference.clear();
  EXPECT_EQ(layout_of(picture).panels, 2);
  const Decoded image(draw_lobe(picture));
  EXPECT_EQ(image.width(), PictureLayout::panel_left(1) + kPanel + PictureLayout::kRight);
  EXPECT_EQ(image.at(PictureLayout::panel_left(1) + 16, layout_of(picture).rectangle_top + 20),
            diverging_color(-1));
}

TEST(Picture, TakesAnyTextAndExtremeValues) {
  LobePicture picture = example(true);
  picture.title = std::string(5000, 'x') + "\n\xff\xc2 \u00b5\u4e2d";
  picture.subtitle = "many short words " + std::string(400, '\xc2');
  picture.truth_label = std::string(300, 't');
  for (const double v : {0.0, -1e308, 1e308, 5e-324, kNan, HUGE_VAL}) {
    picture.truth.assign(picture.truth.size(), v);
    picture.difference = picture.truth;
    picture.z = picture.truth;
    for (const bool logarithmic : {false, true}) {
      picture.logarithmic = logarithmic;
      EXPECT_EQ(Decoded(draw_lobe(picture)).width(), layout_of(picture).width) << v;
    }
  }
}

TEST(Picture, RefusesMapsThatDoNotFitTheGridAndNoMapAtAll) {
  LobePicture picture = example(false);
  picture.z.pop_back();
  EXPECT_THAT(message_of<std::invalid_argument>([&] { (void)draw_lobe(picture); }),
              testing::HasSubstr("31 values on a grid of 32 cells"));
  EXPECT_THROW((void)draw_lobe(LobePicture{}), std::invalid_argument);
}

TEST(Picture, InAnUnwritablePlaceIsAnErrorThatNamesIt) {
  const TemporaryFolder folder;
  const auto draw = [](PictureFormat format) { return draw_lobe(example(false), format); };
  EXPECT_THAT(message_of<OutputError>([&] {
                (void)write_pictures((folder / "none/a").string(), {PictureFormat::png}, draw);
              }),
              testing::HasSubstr((folder / "none/a.png").string()));
}

}  // namespace
}  // namespace lamella
