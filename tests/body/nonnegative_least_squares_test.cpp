#include "body/nonnegative_least_squares.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace pleat::body {
namespace {

// The Karush-Kuhn-Tucker conditions hold exactly at the minimum.
TEST(NonnegativeLeastSquares, SatisfiesOptimality) {
  RandomStream random(5, "nnls");
  for (int trial = 0; trial < 20; ++trial) {
    const int rows = 10 + trial, columns = 5 + 7 * trial;
    Eigen::MatrixXd A(rows, columns);
    Eigen::VectorXd b(rows);
    for (int i = 0; i < A.size(); ++i) A.data()[i] = random.normal();
    for (int i = 0; i < rows; ++i) b[i] = random.normal();
    const Eigen::VectorXd x = nonnegative_least_squares(A, b);
    EXPECT_GE(x.minCoeff(), 0);
    EXPECT_LE((x.array() > 0).count(), rows);
    const Eigen::VectorXd gradient = A.transpose() * (A * x - b);
    for (int j = 0; j < columns; ++j) {
      if (x[j] > 0) {
        EXPECT_NEAR(gradient[j], 0, 1e-7);
      }
      EXPECT_GT(gradient[j], -1e-7);
    }
  }
}

TEST(NonnegativeLeastSquares, LeavesOutWhatWouldBeNegative) {
  const Eigen::VectorXd x =
      nonnegative_least_squares(Eigen::Matrix2d::Identity(), Eigen::Vector2d(2, -3));
  EXPECT_NEAR(x[0], 2, 1e-12);
  EXPECT_EQ(x[1], 0);
}

}  // namespace
}  // namespace pleat::body
