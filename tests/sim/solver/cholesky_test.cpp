#include "sim/solver/cholesky.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace pleat::sim {
namespace {

// A ring with chords; diagonally dominant blocks, so positive definite.
BlockMatrix ring(int count) {
  std::vector<std::pair<int, int>> coupled;
  for (int v = 0; v < count; ++v) {
    coupled.emplace_back(v, (v + 1) % count);
    coupled.emplace_back(v, (v + 5) % count);
  }
  BlockMatrix matrix = make_pattern(count, coupled);
  RandomStream random(11, "ring");
  for (int i = 0; i < count; ++i)
    for (int k = matrix.diagonal[i] + 1; k < matrix.row_start[i + 1]; ++k) {
      for (int e = 0; e < 9; ++e) matrix.values[9 * k + e] = random.normal();
      matrix.block(matrix.find(matrix.column[k], i)) = matrix.block(k).transpose();
    }
  for (int i = 0; i < count; ++i) matrix.block(matrix.diagonal[i]) = 20 * Mat<3>::Identity();
  return matrix;
}

TEST(Cholesky, SolvesWhatMultiplyMakes) {
  const BlockMatrix matrix = ring(60);
  Eigen::VectorXd x(180), b;
  RandomStream random(1, "x");
  for (double& value : x) value = random.normal();
  multiply(matrix, x, b);
  Cholesky factor(matrix);
  ASSERT_TRUE(factor.factor(matrix, Eigen::VectorXd::Zero(60)));
  EXPECT_LE((factor.solve(b) - x).norm(), 1e-12 * x.norm());
}

TEST(Cholesky, AddsOneShiftAVertex) {
  BlockMatrix matrix = ring(30);
  Cholesky factor(matrix);
  const Eigen::VectorXd shift = Eigen::VectorXd::LinSpaced(30, 1, 4);
  ASSERT_TRUE(factor.factor(matrix, shift));
  for (int v = 0; v < 30; ++v) matrix.block(matrix.diagonal[v]) += shift[v] * Mat<3>::Identity();
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(90, -1, 1);
  Eigen::VectorXd b;
  multiply(matrix, x, b);
  EXPECT_LE((factor.solve(b) - x).norm(), 1e-12 * x.norm());
}

TEST(Cholesky, SaysWhereAMatrixIsNotPositive) {
  BlockMatrix matrix = ring(30);
  matrix.block(matrix.diagonal[7]) = -Mat<3>::Identity();
  Cholesky factor(matrix);
  EXPECT_FALSE(factor.factor(matrix, Eigen::VectorXd::Zero(30)));
  EXPECT_TRUE(factor.factor(ring(30), Eigen::VectorXd::Zero(30)));
}

}  // namespace
}  // namespace pleat::sim
