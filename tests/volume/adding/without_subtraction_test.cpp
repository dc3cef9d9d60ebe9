#include "volume/adding/without_subtraction.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cstdio>
#include <random>

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Long = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

// Columns of P that leave `defect`; I - P in long double has its diagonal from the entries beside
// it and the defect, so that its rounding is that of long double alone.
struct Example {
  MatrixXd product, right;
  RowVectorXd defect;
  Long matrix;
};

Example example(Index n, double defect, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto draw = [&](Index rows, Index columns) {
    MatrixXd m(rows, columns);
    for (double& x : m.reshaped()) x = uniform(random);
    return m;
  };
  Example e{draw(n, n), draw(n, 3), defect * draw(1, n), Long(n, n)};
  for (Index c = 0; c < n; ++c) {
    e.product.col(c) *= (1 - e.defect[c]) / e.product.col(c).sum();
    long double beside = 0;
    for (Index r = 0; r < n; ++r)
      if (r != c) {
        e.matrix(r, c) = -static_cast<long double>(e.product(r, c));
        beside += e.product(r, c);
      }
    e.matrix(c, c) = beside + e.defect[c];
  }
  return e;
}

// The condition number is some 1 / defect; an elimination that subtracts loses that many digits.
TEST(WithoutSubtraction, KeepsEveryDigitWhereAlmostNothingIsLost) {
  double worst = 0, plain = 0;
  for (const Index n : {1, 2, 5, 24})
    for (const double defect : {1.0, 1e-2, 1e-4}) {
      const Example e = example(n, defect, static_cast<unsigned>(n));
      const Long exact = e.matrix.partialPivLu().solve(e.right.cast<long double>());
      const MatrixXd found = WithoutSubtraction(e.product, e.defect).solve(e.right);
      const MatrixXd eliminated =
          (MatrixXd::Identity(n, n) - e.product).partialPivLu().solve(e.right);
      const auto error = [&](const MatrixXd& m) {
        return static_cast<double>(
            ((m.cast<long double>() - exact).array() / exact.array()).abs().maxCoeff());
      };
      worst = std::max(worst, error(found));
      plain = std::max(plain, error(eliminated));
    }
  // Long double leaves some 1e-19 / 1e-4; n steps of positive terms leave n roundings or so.
  std::printf("[ error ] %.1e, with subtraction %.1e\n", worst, plain);
  EXPECT_LT(worst, 24 * 4 * 2.3e-16);
  EXPECT_GT(plain, 1e-13);
}

TEST(WithoutSubtraction, NodesThatLightNeverGetsToAnswerNothing) {
  // The last node takes light from none, gives none and loses none.
  MatrixXd product = MatrixXd::Zero(3, 3);
  product(0, 1) = product(1, 0) = 0.5;
  RowVectorXd defect(3);
  defect << 0.5, 0.5, 0;
  const MatrixXd found = WithoutSubtraction(product, defect).solve(MatrixXd::Ones(3, 1));
  EXPECT_DOUBLE_EQ(found(0, 0), 2);
  EXPECT_DOUBLE_EQ(found(1, 0), 2);
  EXPECT_EQ(found(2, 0), 0);
}

}  // namespace
}  // namespace lamella
