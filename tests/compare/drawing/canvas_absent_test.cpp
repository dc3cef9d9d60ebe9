// The program without Cairo: this test links the stand-in of canvas.cpp.
#include <gtest/gtest.h>

#include "compare/drawing/chart.h"
#include "compare/drawing/lobe_picture.h"

namespace lamella {
namespace {

template <class F>
void expect_refusal(const F& draw) {
  try {
    draw();
    FAIL() << "drawn";
  } catch (const PictureError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("-DLAMELLA_CAIRO=OFF"), std::string::npos) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
  }
}

TEST(PicturesWithoutCairo, AreRefusedWithOneLineThatSaysSo) {
  EXPECT_FALSE(Canvas::is_available());
  expect_refusal([] { Canvas::require_available(); });
  LobePicture lobe;
  lobe.grid = {.mu_cells = 4, .phi_cells = 8, .folded = false};
  lobe.truth.assign(32, 1.0);
  expect_refusal([&] { (void)draw_lobe(lobe); });
  const Chart chart{
      .title = "", .subtitle = "", .x_label = "", .y_label = "", .series = {{"a", {0, 1}, {0, 1}}}};
  for (const PictureFormat format : picture_formats(picture_format_names()))
    expect_refusal([&] { (void)draw_chart(chart, format); });
}

}  // namespace
}  // namespace lamella
