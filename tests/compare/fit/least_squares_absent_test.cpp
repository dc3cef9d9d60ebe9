// The program without Ceres: this test links the stand-in of the fits.
#include <gtest/gtest.h>

#include "compare/fit/bounded_least_squares.h"
#include "compare/fit/least_squares.h"
#include "compare/fit/sampler_fit.h"

namespace lamella {
namespace {

template <class F>
void expect_refusal(const F& fit) {
  try {
    fit();
    FAIL() << "fitted";
  } catch (const FitError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("-DLAMELLA_CERES=OFF"), std::string::npos) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
  }
}

TEST(FitsWithoutCeres, AreRefusedWithOneLineThatSaysSo) {
  EXPECT_FALSE(has_least_squares());
  expect_refusal([] { require_least_squares(); });
  expect_refusal(
      [] { (void)fit_sampling_lobes([](double) { return std::unique_ptr<Model>(); }, 2, 2); });
  expect_refusal([] { (void)to_initializers({}); });
  expect_refusal([] { (void)minimum_from({}, {}, {}); });
}

}  // namespace
}  // namespace lamella
