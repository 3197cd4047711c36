#include "sim/solver/trust_region.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "tests/sim/dressed_ball.h"

namespace pleat::sim {
namespace {

// H = Q diag(values) Q^T of full size, a gradient, and a norm M that has nothing to do with either.
struct Quadratic {
  static constexpr int kVertices = 8, kSize = 3 * kVertices;
  Cloth cloth;
  Region region;
  BlockMatrix matrix;
  std::vector<ActiveBarrier> barriers;
  Eigen::MatrixXd H;
  Eigen::VectorXd gradient = random_vector(kSize, "gradient");
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(kSize, kSize);
  Eigen::LLT<Eigen::MatrixXd> factor;

  explicit Quadratic(const Eigen::VectorXd& values) {
    cloth.vertex_count = kVertices;
    std::vector<std::pair<int, int>> coupled;
    for (int v = 0; v < kVertices; ++v) {
      region.vertices.push_back(v);
      region.place.push_back(v);
      for (int w = 0; w < v; ++w) coupled.emplace_back(v, w);
    }
    matrix = make_pattern(kVertices, coupled);
    const Eigen::MatrixXd mixed =
        random_vector(kSize * kSize, "mixed").reshaped(kSize, kSize).householderQr().householderQ();
    H = mixed * values.asDiagonal() * mixed.transpose();
    H = (0.5 * (H + H.transpose())).eval();
    for (int v = 0; v < kVertices; ++v)
      for (int w = 0; w < kVertices; ++w)
        matrix.block(matrix.find(v, w)) = H.block<3, 3>(3 * v, 3 * w);
    for (int i = 0; i < kSize; ++i) M(i, i) = 1 + 0.5 * std::sin(3 * i);
    for (int i = 0; i + 1 < kSize; ++i) M(i, i + 1) = M(i + 1, i) = 0.1;
    factor.compute(M);
  }

  TrustRegionStep step(double radius, TrustRegionConfig config = {1e-10, 60}) const {
    return trust_region_step(
        {cloth, region, matrix, barriers}, gradient, radius, config,
        [this](const Eigen::VectorXd& r, Eigen::VectorXd& z) { z = factor.solve(r); });
  }
  double norm(const Eigen::VectorXd& p) const { return std::sqrt(p.dot(M * p)); }
  double model(const Eigen::VectorXd& p) const { return gradient.dot(p) + 0.5 * p.dot(H * p); }
  // The least of the model within the radius: in coordinates where M is the identity and H
  // diagonal, (H + s) p = -g with s >= 0 as small as the radius allows, found by bisection.
  double least_model(double radius) const {
    const Eigen::MatrixXd L = factor.matrixL();
    const Eigen::MatrixXd half = L.triangularView<Eigen::Lower>().solve(H);
    const Eigen::MatrixXd scaled =
        L.triangularView<Eigen::Lower>().solve(half.transpose()).transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(0.5 * (scaled + scaled.transpose()));
    const Eigen::VectorXd g =
        eigen.eigenvectors().transpose() * L.triangularView<Eigen::Lower>().solve(gradient);
    const Eigen::ArrayXd values = eigen.eigenvalues();
    const auto at = [&](double s) -> Eigen::ArrayXd { return -g.array() / (values + s); };
    double low = std::max(0.0, -values[0]) + 1e-12, high = low + g.norm() / radius;
    if (at(low).matrix().norm() <= radius) high = low;
    for (int i = 0; i < 200; ++i) {
      const double middle = 0.5 * (low + high);
      (at(middle).matrix().norm() > radius ? low : high) = middle;
    }
    const Eigen::ArrayXd p = at(high);
    return g.dot(p.matrix()) + 0.5 * (values * p.square()).sum();
  }
};

const Eigen::VectorXd kConvex = Eigen::VectorXd::LinSpaced(Quadratic::kSize, 0.5, 30);
Eigen::VectorXd saddle() {
  Eigen::VectorXd values = kConvex;
  values[3] = -40;
  return values;
}

void expect_truthful(const Quadratic& problem, const TrustRegionStep& step, double radius) {
  EXPECT_NEAR(step.model, problem.model(step.step), 1e-11 * (1 + std::abs(step.model)));
  EXPECT_NEAR(step.length, problem.norm(step.step), 1e-10 * (1 + step.length));
  EXPECT_LE(step.length, radius * (1 + 1e-12));
  EXPECT_LT(step.model, 0);
  if (step.at_radius) {
    EXPECT_DOUBLE_EQ(step.length, radius);
  }
}

TEST(TrustRegion, IsNewtonsStepWhereThereIsRoom) {
  const Quadratic problem(kConvex);
  const Eigen::VectorXd newton = problem.H.ldlt().solve(-problem.gradient);
  const TrustRegionStep step = problem.step(1.01 * problem.norm(newton));
  expect_truthful(problem, step, 1.01 * problem.norm(newton));
  EXPECT_LE((step.step - newton).norm(), 1e-8 * newton.norm());
  EXPECT_FALSE(step.at_radius);
  EXPECT_FALSE(step.has_negative_curvature);
  EXPECT_LE(step.iterations, Quadratic::kSize + 1);
}

// Where the model is convex, at least half of what the best step within the radius would gain: Yuan
// 2000, "On the Truncated Conjugate Gradient Method".
TEST(TrustRegion, GainsHalfOfTheBestAtLeast) {
  const Quadratic problem(kConvex);
  const double newton = problem.norm(problem.H.ldlt().solve(-problem.gradient));
  double last = 0;
  for (const double share : {0.01, 0.1, 0.3, 0.6, 0.9, 0.999}) {
    const TrustRegionStep step = problem.step(share * newton);
    expect_truthful(problem, step, share * newton);
    EXPECT_TRUE(step.at_radius);
    EXPECT_FALSE(step.has_negative_curvature);
    const double best = problem.least_model(share * newton);
    EXPECT_LE(step.model, 0.5 * best);
    EXPECT_GE(step.model, best * (1 + 1e-9));
    EXPECT_LT(step.model, last);  // more room, more gain
    last = step.model;
    // In so small a region only the slope counts, and nothing is better than its steepest descent.
    if (share == 0.01) {
      EXPECT_LE(step.model, 0.99 * best);
    }
  }
}

// Cut, a step is what a shorter radius would have made of it, along negative curvature too.
TEST(TrustRegion, IsCutToWhatAShorterRadiusGives) {
  for (const Eigen::VectorXd& values : {kConvex, saddle()}) {
    const Quadratic problem(values);
    const TrustRegionStep far = problem.step(100, {1e-10, 60, true});
    for (const double share : {0.001, 0.1, 0.5, 0.9, 0.999}) {
      const double radius = share * far.length;
      const Eigen::VectorXd shorter = problem.step(radius, {1e-10, 60, true}).step;
      EXPECT_LE((far.cut(radius) - shorter).norm(), 1e-9 * shorter.norm()) << share;
      EXPECT_NEAR(problem.norm(far.cut(radius)), radius, 1e-9 * radius);
    }
    EXPECT_LE((far.cut(2 * far.length) - far.step).norm(), 1e-12 * far.step.norm());
  }
}

TEST(TrustRegion, FollowsNegativeCurvatureToTheRadiusAtASaddle) {
  const Quadratic problem(saddle());
  for (const double radius : {0.1, 1.0, 10.0, 100.0}) {
    const TrustRegionStep step = problem.step(radius, {1e-10, 60, true});
    expect_truthful(problem, step, radius);
    EXPECT_TRUE(step.at_radius);
    EXPECT_GE(step.model, problem.least_model(radius) * (1 + 1e-9));
    // No worse than the best along the first direction.
    const Eigen::VectorXd down = -problem.factor.solve(problem.gradient);
    const double curvature = down.dot(problem.H * down);
    double length = radius / problem.norm(down);
    if (curvature > 0) length = std::min(length, -problem.gradient.dot(down) / curvature);
    EXPECT_LE(step.model, problem.model(length * down) * (1 - 1e-12));
    if (radius < 100) continue;
    EXPECT_TRUE(step.has_negative_curvature);
    EXPECT_LT(step.step.dot(problem.H * step.step), 0);  // far out, the saddle is left behind
  }
}

TEST(TrustRegion, GoesAlongNegativeCurvatureNoFartherThanItCameElsewhere) {
  const Quadratic problem(saddle());
  const TrustRegionStep near = problem.step(100), far = problem.step(1e4);
  expect_truthful(problem, near, near.length);
  EXPECT_TRUE(near.has_negative_curvature);
  EXPECT_EQ(near.step, far.step);
  const TrustRegionStep along = problem.step(100, {1e-10, 60, true});
  EXPECT_LT(near.length, 0.5 * along.length);
  EXPECT_EQ(near.iterations, along.iterations);
  const TrustRegionStep before = problem.step(100, {1e-10, near.iterations - 1});
  EXPECT_FALSE(before.has_negative_curvature);
  EXPECT_NEAR(near.length, 2 * before.length, 1e-9 * near.length);
}

// Where nothing resists, the step would have no end.
TEST(TrustRegion, GoesToTheRadiusWhereTheModelIsFlat) {
  const Quadratic problem(Eigen::VectorXd::Zero(Quadratic::kSize));
  const TrustRegionStep step = problem.step(2);
  expect_truthful(problem, step, 2);
  EXPECT_TRUE(step.at_radius);
  EXPECT_TRUE(step.has_negative_curvature);
  const Eigen::VectorXd down = -problem.factor.solve(problem.gradient);
  EXPECT_LE((step.step - 2 / problem.norm(down) * down).norm(), 1e-12);
}

TEST(TrustRegion, WithoutRadiusTakesTheFirstGradients) {
  const Quadratic problem(0.01 * kConvex);
  const double first = problem.norm(problem.factor.solve(problem.gradient));
  const TrustRegionStep step = problem.step(0);
  expect_truthful(problem, step, first);
  EXPECT_TRUE(step.at_radius);
  EXPECT_EQ(step.step, problem.step(first).step);
}

TEST(TrustRegion, StopsAtItsToleranceOrItsLimit) {
  const Quadratic problem(kConvex);
  const auto residual = [&](const TrustRegionStep& step) {
    const Eigen::VectorXd r = -problem.gradient - problem.H * step.step;
    return std::sqrt(r.dot(problem.factor.solve(r)) /
                     problem.gradient.dot(problem.factor.solve(problem.gradient)));
  };
  int last = 0;
  for (const double tolerance : {0.5, 0.1, 1e-3}) {
    const TrustRegionStep step = problem.step(1e3, {tolerance, 60});
    EXPECT_LE(residual(step), tolerance);
    EXPECT_GT(step.iterations, last);
    last = step.iterations;
  }
  for (const int most : {1, 2, 5}) {
    const TrustRegionStep step = problem.step(1e3, {1e-10, most});
    EXPECT_EQ(step.iterations, most);
    EXPECT_LE(residual(step), 1);
  }
}

TEST(TrustRegion, OfNoGradientIsNone) {
  Quadratic problem(saddle());
  problem.gradient.setZero();
  const TrustRegionStep step = problem.step(1);
  EXPECT_EQ(step.step, Eigen::VectorXd::Zero(Quadratic::kSize));
  EXPECT_EQ(step.model, 0);
}

// On a cloth with contact and barriers: what is foretold is what the energy does, to third order.
TEST(TrustRegion, ForetellsTheEnergyOfACloth) {
  DressedBall scene;
  const Held held(scene, whole(scene.cloth));
  const System at = held.system(scene.x, Order::kHessian);
  const std::vector<ActiveBarrier> barriers = held.barriers(scene.x, Order::kHessian);
  const NewtonSystem system{scene.cloth, held.region, at.hessian, barriers};
  const auto scaled = [](const Eigen::VectorXd& r, Eigen::VectorXd& z) { z = 1e-3 * r; };
  double last = 1;
  for (const double length : {1e-5, 1e-6}) {  // m, of all vertices together
    const TrustRegionStep step =
        trust_region_step(system, at.gradient, std::sqrt(1e3) * length, {1e-3, 200}, scaled);
    EXPECT_TRUE(step.at_radius);
    const double change = held.system(scene.x + step.step, Order::kValue).energy - at.energy;
    const double error = std::abs(change / step.model - 1);
    EXPECT_LT(error, 0.1);
    EXPECT_LT(error, last / 5);
    last = error;
  }
}

}  // namespace
}  // namespace pleat::sim
