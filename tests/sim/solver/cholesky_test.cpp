#include "sim/solver/cholesky.h"

#include <gtest/gtest.h>

#include <array>

#include "core/random.h"
#include "tests/sim/dressed_ball.h"

namespace pleat::sim {
namespace {

void multiply(const BlockMatrix& matrix, const Eigen::VectorXd& x, Eigen::VectorXd& y) {
  y = dense(matrix) * x;
}

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
  EXPECT_FALSE(factor.factor_roughly(matrix, Eigen::VectorXd::Zero(30)));
  EXPECT_TRUE(factor.factor_roughly(ring(30), Eigen::VectorXd::Zero(30)));
}

// As the solver does where layers of cloth come near and part again.
TEST(Cholesky, TakesAWiderPatternAndANarrowerOne) {
  std::vector<std::pair<int, int>> coupled = {{3, 50}, {3, 51}, {4, 50}};
  const BlockMatrix matrix = ring(60);
  for (int v = 0; v < 60; ++v)
    for (int k = matrix.row_start[v]; k < matrix.row_start[v + 1]; ++k)
      coupled.emplace_back(v, matrix.column[k]);
  BlockMatrix wider = make_pattern(60, coupled);
  for (int v = 0; v < 60; ++v)
    for (int k = matrix.row_start[v]; k < matrix.row_start[v + 1]; ++k)
      wider.block(wider.find(v, matrix.column[k])) = matrix.block(k);
  for (const auto& [a, b] : {std::pair{3, 50}, {3, 51}, {4, 50}}) {
    wider.block(wider.find(a, b)) = Mat<3>::Constant(0.3);
    wider.block(wider.find(b, a)) = Mat<3>::Constant(0.3);
  }
  Cholesky factor(matrix);
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(180, -1, 1);
  for (const BlockMatrix* each : std::array<const BlockMatrix*, 3>{&matrix, &wider, &matrix}) {
    Eigen::VectorXd b, rough;
    multiply(*each, x, b);
    ASSERT_TRUE(factor.factor(*each, Eigen::VectorXd::Zero(60)));
    EXPECT_LE((factor.solve(b) - x).norm(), 1e-12 * x.norm());
    ASSERT_TRUE(factor.factor_roughly(*each, Eigen::VectorXd::Zero(60)));
    factor.solve_roughly(b, rough);
    EXPECT_LE((rough - x).norm(), 1e-5 * x.norm());
  }
}

// In single precision: 1e-7 times what the matrix amplifies. Supernodes of many shapes occur.
TEST(Cholesky, SolvesRoughlyToSinglePrecision) {
  for (const int count : {1, 2, 17, 60, 400}) {
    const BlockMatrix matrix = count < 17 ? make_pattern(count, {{0, count - 1}}) : ring(count);
    const Eigen::VectorXd shift = Eigen::VectorXd::LinSpaced(count, 1, 4);
    Cholesky factor(matrix);
    const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(3 * count, -1, 1);
    ASSERT_TRUE(factor.factor(matrix, shift));
    const Eigen::VectorXd exact = factor.solve(b);
    ASSERT_TRUE(factor.factor_roughly(matrix, shift));
    Eigen::VectorXd rough;
    factor.solve_roughly(b, rough);
    EXPECT_LE((rough - exact).norm(), 3e-6 * exact.norm()) << count;
    EXPECT_GT(exact.norm(), 0);
    factor.solve_roughly(2 * b, rough);  // its scratch space does not show
    EXPECT_LE((rough - 2 * exact).norm(), 6e-6 * exact.norm()) << count;
  }
}

// One factorisation after another: each solves with the last one.
TEST(Cholesky, SolvesRoughlyWithTheLastMatrix) {
  const BlockMatrix matrix = ring(60);
  Cholesky factor(matrix);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(180, -1, 1);
  Eigen::VectorXd rough;
  for (const double shift : {1.0, 50.0}) {
    ASSERT_TRUE(factor.factor(matrix, Eigen::VectorXd::Constant(60, shift)));
    const Eigen::VectorXd exact = factor.solve(b);
    ASSERT_TRUE(factor.factor_roughly(matrix, Eigen::VectorXd::Constant(60, shift)));
    factor.solve_roughly(b, rough);
    EXPECT_LE((rough - exact).norm(), 3e-6 * exact.norm());
  }
}

}  // namespace
}  // namespace pleat::sim
