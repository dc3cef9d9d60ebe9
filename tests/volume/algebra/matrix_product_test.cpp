#include "volume/algebra/matrix_product.h"

#include <gtest/gtest.h>

namespace lamella {
namespace {

using Eigen::MatrixXd;

// Sums of k products of numbers below 1 in another order: an error of k units in the last place.
TEST(MatrixProduct, IsEigensOnEverySetForEveryShape) {
  for (const Isa isa : supported_isas())
    for (const int rows : {0, 1, 2, 5, 8, 23, 24, 25, 70})
      for (const int columns : {0, 1, 3, 4, 8, 9, 31})
        for (const int inner : {0, 1, 7, 24, 255, 256, 300}) {
          const MatrixXd a = MatrixXd::Random(rows, inner), b = MatrixXd::Random(inner, columns);
          const MatrixXd expected = a * b, found = MatrixProduct(isa)(a, b);
          ASSERT_EQ(found.rows(), rows);
          ASSERT_EQ(found.cols(), columns);
          if (found.size() == 0) continue;
          ASSERT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-15 * (inner + 1))
              << to_text(isa) << ' ' << rows << ' ' << columns << ' ' << inner;
        }
}

TEST(MatrixProduct, OfBlocksLeavesWhatIsBesideThem) {
  for (const Isa isa : supported_isas()) {
    const MatrixXd a = MatrixXd::Random(40, 30), b = MatrixXd::Random(50, 20);
    MatrixXd c = MatrixXd::Random(60, 40), expected = c;
    expected.block(3, 5, 27, 13) += a.block(2, 4, 27, 19) * b.block(6, 3, 19, 13);
    MatrixProduct(isa).add(a.block(2, 4, 27, 19), b.block(6, 3, 19, 13), c.block(3, 5, 27, 13));
    EXPECT_LT((c - expected).cwiseAbs().maxCoeff(), 1e-13) << to_text(isa);
  }
}

}  // namespace
}  // namespace lamella
