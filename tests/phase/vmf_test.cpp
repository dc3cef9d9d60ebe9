#include "phase/vmf.h"

#include <gtest/gtest.h>

#include <limits>

namespace lamella {
namespace {

TEST(Vmf, OddPartOfSigmaIsTheMeanCosine) {
  for (const double alpha : {0.01, 0.1, 0.5, 1.0, 3.0, 100.0})
    for (const double u : {0.01, 0.3, 0.7, 1.0})
      EXPECT_NEAR(vmf_sigma(u, alpha) - vmf_sigma(-u, alpha),
                  u * vmf_mean_cosine(vmf_concentration(alpha)), 2e-15)
          << alpha << ' ' << u;
}

TEST(Vmf, UniformNormalsHaveSigmaOneQuarter) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_DOUBLE_EQ(vmf_sigma(0.3, infinity), 0.25);
  EXPECT_DOUBLE_EQ(vmf_alpha(1), infinity);
}

}  // namespace
}  // namespace lamella
