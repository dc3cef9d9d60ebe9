#include "compare/request/percent.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "phase/math/luminance.h"

namespace lamella {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Percent, HasTwoDigitsAndNoPowersOfTen) {
  const std::vector<std::pair<double, std::string>> cases = {{0, "0 %"},
                                                             {0.41, "41 %"},
                                                             {0.0083, "0.83 %"},
                                                             {0.083, "8.3 %"},
                                                             {0.0996, "10 %"},
                                                             {0.09949, "9.9 %"},
                                                             {0.995, "100 %"},
                                                             {1.2, "120 %"},
                                                             {1.234, "123 %"},
                                                             {84.7, "8470 %"},
                                                             {9999.99, "999999 %"},
                                                             {1e17, "above 1000000 %"},
                                                             {-1e17, "below -1000000 %"},
                                                             {1.5e-7, "0.000015 %"},
                                                             {1e-12, "below 0.00000001 %"},
                                                             {-1e-12, "above -0.00000001 %"},
                                                             {kInfinity, "inf %"},
                                                             {-kInfinity, "-inf %"},
                                                             {std::nan(""), "-"}};
  for (const auto& [share, text] : cases) EXPECT_EQ(percent_text(share), text) << share;
}

TEST(Percent, OfAColumnHasTwoDecimalsBelowAHundred) {
  EXPECT_EQ(percent_cell(0.40699), "40.70 %");
  EXPECT_EQ(percent_cell(0), "0.00 %");
  EXPECT_EQ(percent_cell(0.99994), "99.99 %");
  EXPECT_EQ(percent_cell(0.99996), "100 %");
  EXPECT_EQ(percent_cell(1.23456), "123 %");
  EXPECT_EQ(percent_cell(kInfinity), "inf %");
  EXPECT_EQ(signed_percent_cell(0.0123), "+1.23 %");
  EXPECT_EQ(signed_percent_cell(-1.5), "-150 %");
}

TEST(Percent, NeverHasAnExponent) {
  for (double share = 1e-30; share < 1e30; share *= 1.7)
    for (const std::string& text :
         {percent_text(share), percent_cell(share), signed_percent_cell(-share)})
      EXPECT_EQ(text.find_first_not_of("0123456789.+- %abovelw"), std::string::npos) << text;
}

TEST(Luminance, HasTheWeightsOfRec709AndKeepsGrey) {
  EXPECT_DOUBLE_EQ(luminance(Rgb(1, 0, 0)), 0.2126);
  EXPECT_DOUBLE_EQ(luminance(Rgb(0, 1, 0)), 0.7152);
  EXPECT_DOUBLE_EQ(luminance(Rgb(0, 0, 1)), 0.0722);
  EXPECT_DOUBLE_EQ(luminance(Rgb(0.3)), 0.3);
  const std::vector<double> grey{0.7}, colour{0.9, 0.5, 0.2};
  EXPECT_EQ(luminance(grey), 0.7);
  EXPECT_DOUBLE_EQ(luminance(colour), 0.2126 * 0.9 + 0.7152 * 0.5 + 0.0722 * 0.2);
}

}  // namespace
}  // namespace lamella
