#include "sim/solver/pair_distance.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/proximity.h"
#include "tests/core/shapes.h"

namespace pleat::sim {
namespace {

// The independent judges: for a face the closest point by Voronoi regions (itself judged by CGAL),
// for edges the least over one of them, a convex function, by cutting thirds off.
double point_to_edge(const Vec<3>& p, const Vec<3>& a, const Vec<3>& b) {
  const double length = (b - a).squaredNorm();
  const double t = length > 0 ? std::clamp((p - a).dot(b - a) / length, 0.0, 1.0) : 0.0;
  return (p - a - t * (b - a)).squaredNorm();
}
double brute_force(PairKind kind, const PairPoints& x) {
  if (kind == PairKind::kPointFace) {
    const Vec<3> weights = closest_on_triangle(x.col(0), x.col(1), x.col(2), x.col(3));
    return (x.col(0) - x.rightCols(3) * weights).squaredNorm();
  }
  const auto at = [&](double s) {
    return point_to_edge((1 - s) * x.col(0) + s * x.col(1), x.col(2), x.col(3));
  };
  double low = 0, high = 1;
  for (int i = 0; i < 200; ++i) {
    const double left = low + (high - low) / 3, right = high - (high - low) / 3;
    const bool is_left = at(left) <= at(right);
    if (is_left) high = right;
    if (!is_left) low = left;
  }
  return std::min({at(0), at(1), at(low)});
}

// What any answer must satisfy. Lengths are about 1, so that rounding is 1e-15 of the distance's
// terms; where features nearly touch, that of a square.
void expect_distance(PairKind kind, const PairPoints& x, double tolerance = 1e-13) {
  const PairDistance found = pair_distance(kind, x);
  EXPECT_NEAR(found.squared, brute_force(kind, x), tolerance);
  EXPECT_EQ(squared_pair_distance(kind, x), found.squared);
  EXPECT_EQ(found.difference.squaredNorm(), found.squared);
  const Vec<4>& w = found.weights;
  EXPECT_LE((x * w - found.difference).norm(), 1e-15);
  const int first = kind == PairKind::kPointFace ? 1 : 2;  // corners of the first feature
  EXPECT_NEAR(w.head(first).sum(), 1, 1e-15);
  EXPECT_NEAR(w.sum(), 0, 1e-15);
  EXPECT_GE(w.head(first).minCoeff(), 0);
  EXPECT_LE(w.tail(4 - first).maxCoeff(), 0);
  for (int k = 0; k < 2; ++k) {
    const Vec<4> direction = found.directions.col(k);
    if (k >= found.free) {
      EXPECT_EQ(direction, Vec<4>::Zero());
      continue;
    }
    EXPECT_GT(direction.norm(), 0);
    EXPECT_EQ(direction.head(first).sum(), 0);  // stays on the features
    EXPECT_EQ(direction.sum(), 0);
    const Vec<3> across = x * direction;
    EXPECT_NEAR(across.dot(found.difference), 0, 1e-13 * across.norm());  // d(D/2): none is left
    EXPECT_EQ((w.array() == 0 && direction.array() != 0).count(), 0);     // it is free to move
  }
}

PairPoints random_pair(RandomStream& random) {
  PairPoints x;
  for (int k = 0; k < 4; ++k) x.col(k) = random_point(random);
  return x;
}

TEST(PairDistance, OfRandomFeaturesIsTheLeast) {
  RandomStream random(1, "pairs");
  int free[2][3] = {};
  for (int i = 0; i < 3000; ++i) {
    const PairPoints x = random_pair(random);
    for (const PairKind kind : {PairKind::kPointFace, PairKind::kEdgeEdge}) {
      expect_distance(kind, x);
      ++free[static_cast<int>(kind)][pair_distance(kind, x).free];
    }
    if (testing::Test::HasFailure()) return;
  }
  for (const auto& of_kind : free)  // every kind of place occurs
    for (const int count : of_kind) EXPECT_GT(count, 200);
}

// Coordinates on a coarse grid: points on edges and corners, parallel and crossing edges, features
// that touch, triangles and edges without extent.
TEST(PairDistance, OnAGridIsTheLeast) {
  RandomStream random(1, "grid");
  int flat = 0, parallel = 0;
  for (int i = 0; i < 10000; ++i) {
    PairPoints x;
    for (double& coordinate : x.reshaped())
      coordinate = 0.25 * static_cast<double>(random.below(4));
    for (const PairKind kind : {PairKind::kPointFace, PairKind::kEdgeEdge})
      expect_distance(kind, x);
    flat += (x.col(2) - x.col(1)).cross(x.col(3) - x.col(1)).norm() == 0;
    parallel += (x.col(1) - x.col(0)).cross(x.col(3) - x.col(2)).norm() == 0;
    if (testing::Test::HasFailure()) {
      ADD_FAILURE() << x;
      return;
    }
  }
  EXPECT_GT(flat, 200);
  EXPECT_GT(parallel, 200);
}

PairPoints points(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d) {
  PairPoints x;
  x << a, b, c, d;
  return x;
}

TEST(PairDistance, NamesThePlaceOnAFace) {
  const Vec<3> a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  const auto place = [&](double x, double y) {
    return pair_distance(PairKind::kPointFace, points({x, y, 0.5}, a, b, c));
  };
  const auto expect_place = [&](double x, double y, const Vec<4>& weights, int free) {
    EXPECT_LE((place(x, y).weights - weights).norm(), 1e-15) << x << " " << y;
    EXPECT_EQ(place(x, y).free, free) << x << " " << y;
  };
  expect_place(0.25, 0.5, {1, -0.25, -0.25, -0.5}, 2);
  expect_place(0.25, -1, {1, -0.75, -0.25, 0}, 1);
  expect_place(1, 1, {1, 0, -0.5, -0.5}, 1);
  expect_place(-1, 0.25, {1, -0.75, 0, -0.25}, 1);
  expect_place(-1, -2, {1, -1, 0, 0}, 0);
  expect_place(3, 1, {1, 0, -1, 0}, 0);
  expect_place(-1, 3, {1, 0, 0, -1}, 0);
}

TEST(PairDistance, NamesThePlaceOnEdges) {
  const Vec<3> a(-1, 0, 0), b(1, 0, 0);
  const auto expect_place = [&](const Vec<3>& c, const Vec<3>& d, const Vec<4>& weights, int free) {
    const PairDistance there = pair_distance(PairKind::kEdgeEdge, points(a, b, c, d));
    EXPECT_LE((there.weights - weights).norm(), 1e-15) << c.transpose() << ", " << d.transpose();
    EXPECT_EQ(there.free, free) << c.transpose() << ", " << d.transpose();
    // And with the two edges' roles changed.
    const PairDistance back = pair_distance(PairKind::kEdgeEdge, points(c, d, a, b));
    EXPECT_LE((back.difference + there.difference).norm(), 1e-15);
  };
  expect_place({0, -1, 1}, {0, 3, 1}, {0.5, 0.5, -0.75, -0.25}, 2);
  expect_place({0.5, 1, 1}, {0.5, 3, 1}, {0.25, 0.75, -1, 0}, 1);
  expect_place({0.5, 3, 1}, {0.5, 1, 1}, {0.25, 0.75, 0, -1}, 1);
  expect_place({3, -1, 1}, {3, 1, 1}, {0, 1, -0.5, -0.5}, 1);
  expect_place({-3, -1, 1}, {-3, 1, 1}, {1, 0, -0.5, -0.5}, 1);
  expect_place({3, 1, 1}, {3, 2, 1}, {0, 1, -1, 0}, 0);
  expect_place({-3, 2, 1}, {-3, 1, 1}, {1, 0, 0, -1}, 0);
}

// All along parallel edges is equally near: any place of the overlap will do.
TEST(PairDistance, OfParallelEdgesIsTheirGap) {
  const auto squared = [](double from, double to) {
    const PairPoints x = points({0, 0, 0}, {1, 0, 0}, {from, 0.5, 0}, {to, 0.5, 0});
    expect_distance(PairKind::kEdgeEdge, x);
    EXPECT_LE(pair_distance(PairKind::kEdgeEdge, x).free, 1);
    return squared_pair_distance(PairKind::kEdgeEdge, x);
  };
  EXPECT_DOUBLE_EQ(squared(0.25, 0.75), 0.25);
  EXPECT_DOUBLE_EQ(squared(0.75, -3), 0.25);
  EXPECT_DOUBLE_EQ(squared(-1, 2), 0.25);
  EXPECT_DOUBLE_EQ(squared(1, 2), 0.25);
  EXPECT_DOUBLE_EQ(squared(2, 3), 1.25);
  EXPECT_DOUBLE_EQ(squared(-2, -1), 1.25);
}

// Below a sine of 1e-5 edges count as parallel: what that leaves out is 1e-5 of an edge's length.
TEST(PairDistance, OfNearlyParallelEdgesIsTheLeast) {
  RandomStream random(2, "nearly parallel");
  for (double sine = 1e-2; sine > 1e-9; sine /= 3)
    for (int i = 0; i < 100; ++i) {
      const Vec<3> along = random_point(random).normalized(), gap = 0.1 * random_point(random);
      const Vec<3> other = (along + sine * random_point(random)).normalized();
      const double from = 2 * random.uniform() - 1, to = 2 * random.uniform() - 1;
      const PairPoints x =
          points(Vec<3>::Zero(), along, from * along + gap, from * along + gap + to * other);
      const double found = std::sqrt(squared_pair_distance(PairKind::kEdgeEdge, x));
      EXPECT_NEAR(found, std::sqrt(brute_force(PairKind::kEdgeEdge, x)), sine > 3e-5 ? 1e-9 : 3e-5);
    }
}

TEST(PairDistance, OfFeaturesWithoutExtentIsThatOfWhatIsLeft) {
  const Vec<3> a(0, 0, 0), b(1, 0, 0), m(0.25, 0, 0), p(0.5, 1, 0);
  const auto face = [&p](const Vec<3>& u, const Vec<3>& v, const Vec<3>& w) {
    const PairPoints x = points(p, u, v, w);
    expect_distance(PairKind::kPointFace, x);
    return squared_pair_distance(PairKind::kPointFace, x);
  };
  EXPECT_DOUBLE_EQ(face(a, b, m), 1);
  EXPECT_DOUBLE_EQ(face(a, a, b), 1);
  EXPECT_DOUBLE_EQ(face(b, b, b), 1.25);
  const auto edge = [&](const Vec<3>& u, const Vec<3>& v) {
    const PairPoints x = points(p, p, u, v);
    expect_distance(PairKind::kEdgeEdge, x);
    return squared_pair_distance(PairKind::kEdgeEdge, x);
  };
  EXPECT_DOUBLE_EQ(edge(a, b), 1);
  EXPECT_DOUBLE_EQ(edge(b, b), 1.25);
}

TEST(PairDistance, SineIsThatOfTheEdges) {
  for (const double angle : {0.0, 1e-4, 0.3, 1.5}) {
    const PairPoints x =
        points({1, 1, 1}, {3, 1, 1}, {0, 0, 0}, {0.1 * std::cos(angle), 0.1 * std::sin(angle), 0});
    EXPECT_NEAR(squared_sine_of_edges(x), std::sin(angle) * std::sin(angle), 1e-15);
  }
}

}  // namespace
}  // namespace pleat::sim
