#include "sim/solver/newton_system.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "tests/sim/dressed_ball.h"

namespace pleat::sim {
namespace {

// The whole Hessian, barriers and all, from its blocks; rows and columns of the region in its
// order.
Eigen::MatrixXd dense_system(const NewtonSystem& system) {
  Eigen::MatrixXd all = dense(system.matrix);
  const int count = system.matrix.rows();
  for (const ActiveBarrier& barrier : system.barriers)
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) {
        const int v = barrier.element.vertices[a], w = barrier.element.vertices[b];
        if (v < count && w < count)
          all.block<3, 3>(3 * v, 3 * w) += hessian_block(barrier.term, a, b);
      }
  const std::vector<int>& inside = system.region.vertices;
  Eigen::MatrixXd result(3 * inside.size(), 3 * inside.size());
  for (size_t i = 0; i < inside.size(); ++i)
    for (size_t j = 0; j < inside.size(); ++j)
      result.block<3, 3>(3 * i, 3 * j) = all.block<3, 3>(3 * inside[i], 3 * inside[j]);
  return result;
}

struct Linear {
  DressedBall scene;
  Held held;
  std::vector<ActiveBarrier> barriers;
  System assembled;

  // steps < 0: the whole cloth, else around two vertices.
  explicit Linear(int steps = -1, Order order = Order::kHessian)
      : held(scene, steps < 0 ? whole(scene.cloth) : around(scene.cloth, {9, 90}, steps)),
        barriers(held.barriers(scene.x, order)),
        assembled(held.system(scene.x, order)) {}
  NewtonSystem system() const { return {scene.cloth, held.region, assembled.hessian, barriers}; }
};

TEST(NewtonSystem, ProductIsThatOfTheDenseMatrix) {
  for (const int steps : {-1, 1, 2}) {
    const Linear linear(steps);
    ASSERT_GT(linear.barriers.size(), 10u);
    const Eigen::MatrixXd matrix = dense_system(linear.system());
    const Eigen::VectorXd p = random_vector(matrix.rows(), "p");
    Eigen::VectorXd product;
    multiply(linear.system(), p, product);
    EXPECT_LE((product - matrix * p).norm(), 1e-14 * matrix.norm() * p.norm()) << steps;
  }
}

// Central differences of 1e-9 m: 1e-5 of them is left.
TEST(NewtonSystem, ProductIsTheChangeOfTheGradient) {
  for (const int steps : {-1, 1}) {
    const Linear linear(steps);
    const Eigen::VectorXd p = random_vector(3 * linear.held.region.vertices.size(), "p");
    Eigen::VectorXd product, way = Eigen::VectorXd::Zero(linear.scene.x.size());
    multiply(linear.system(), p, product);
    spread(linear.held.region, p, way);
    const double h = 1e-9;
    const auto gradient = [&](double at) {
      const Eigen::VectorXd x = linear.scene.x + at * way;
      return restrict_to(linear.held.region, linear.held.system(x, Order::kGradient).gradient);
    };
    EXPECT_LE(((gradient(h) - gradient(-h)) / (2 * h) - product).norm(), 1e-5 * product.norm());
  }
}

TEST(NewtonSystem, PinnedVerticesGoTheirOwnWay) {
  Linear linear;
  linear.scene.cloth.is_pinned.assign(linear.scene.cloth.vertex_count, 0);
  for (const int v : {0, 70}) linear.scene.cloth.is_pinned[v] = 1;
  Eigen::VectorXd p = random_vector(linear.scene.x.size(), "p"), product;
  multiply(linear.system(), p, product);
  for (const int v : {0, 70}) EXPECT_EQ(product.segment<3>(3 * v), p.segment<3>(3 * v));
  // Where they stay, the others do not notice.
  for (const int v : {0, 70}) p.segment<3>(3 * v).setZero();
  Eigen::VectorXd expected = dense_system(linear.system()) * p;
  for (const int v : {0, 70}) expected.segment<3>(3 * v).setZero();
  multiply(linear.system(), p, product);
  EXPECT_LE((product - expected).norm(), 1e-12 * expected.norm());
}

TEST(WithBarriers, IsTheDenseMatrix) {
  for (const Order order : {Order::kProjectedHessian, Order::kHessian}) {
    const Linear linear(-1, order);
    const BlockMatrix matrix = with_barriers(linear.system());
    const Eigen::MatrixXd expected = dense_system(linear.system());
    EXPECT_LE((dense(matrix) - expected).norm(), 1e-14 * expected.norm());
    EXPECT_GT(matrix.block_count(), linear.assembled.hessian.block_count());
    for (int v = 0; v < matrix.rows(); ++v) EXPECT_EQ(matrix.column[matrix.diagonal[v]], v);
  }
}

// The body's own vertices are no unknowns: barriers with it do not widen the pattern.
TEST(WithBarriers, KeepsThePatternWhereOnlyTheBodyIsNear) {
  Linear linear;
  const int count = linear.scene.cloth.vertex_count;
  std::vector<ActiveBarrier> with_body;
  for (const ActiveBarrier& barrier : linear.barriers)
    if (barrier.element.vertices[3] >= count || barrier.element.vertices[0] >= count)
      with_body.push_back(barrier);
  ASSERT_GT(with_body.size(), 10u);
  linear.barriers = with_body;
  const BlockMatrix matrix = with_barriers(linear.system());
  EXPECT_EQ(matrix.column, linear.assembled.hessian.column);
  EXPECT_EQ(matrix.row_start, linear.assembled.hessian.row_start);
  const Eigen::MatrixXd expected = dense_system(linear.system());
  EXPECT_LE((dense(matrix) - expected).norm(), 1e-14 * expected.norm());
}

TEST(InverseBlocks, InvertThePositiveOfTheDiagonal) {
  int negative = 0;
  for (const int steps : {-1, 1}) {
    Linear linear(steps);
    Mat<3> saddle;  // with negative and with little curvature
    saddle << 2, 1, 0, 1, -3, 0, 0, 0, 1e-9;
    const int v = linear.held.region.vertices[4];
    linear.assembled.hessian.block(linear.assembled.hessian.diagonal[v]) = 1e3 * saddle;
    const Eigen::MatrixXd matrix = dense_system(linear.system());
    const std::vector<Mat<3>> inverse = inverse_blocks(linear.system());
    ASSERT_EQ(inverse.size(), linear.held.region.vertices.size());
    for (size_t i = 0; i < inverse.size(); ++i) {
      const Mat<3> block = matrix.block<3, 3>(3 * i, 3 * i);
      const Eigen::SelfAdjointEigenSolver<Mat<3>> eigen(block), eigen_inverse(inverse[i]);
      const Vec<3> sizes = eigen.eigenvalues().cwiseAbs();
      const Vec<3> expected = sizes.cwiseMax(1e-3 * sizes.maxCoeff()).cwiseInverse();
      const Mat<3>& vectors = eigen.eigenvectors();
      EXPECT_LE((inverse[i] - vectors * expected.asDiagonal() * vectors.transpose()).norm(),
                1e-9 * inverse[i].norm());
      EXPECT_GT(eigen_inverse.eigenvalues()[0], 0);
      negative += eigen.eigenvalues()[0] < 0;
    }
  }
  EXPECT_GE(negative, 2);
}

TEST(RestrictTo, IsUndoneBySpread) {
  const DressedBall scene;
  const Region region = around(scene.cloth, {9, 90}, 1);
  const Eigen::VectorXd all = random_vector(scene.x.size(), "all");
  const Eigen::VectorXd part = restrict_to(region, all);
  ASSERT_EQ(part.size(), static_cast<Eigen::Index>(3 * region.vertices.size()));
  Eigen::VectorXd back = Eigen::VectorXd::Constant(all.size(), 8);
  spread(region, part, back);
  for (int v = 0; v < scene.cloth.vertex_count; ++v)
    EXPECT_EQ(back.segment<3>(3 * v), region.place[v] >= 0 ? Vec<3>(all.segment<3>(3 * v))
                                                            : Vec<3>(Vec<3>::Constant(8)));
}

}  // namespace
}  // namespace pleat::sim
