#include "sim/solver/continuous_collision.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/core/shapes.h"

namespace pleat::sim {
namespace {

constexpr double kKeep = 0.1;

double distance_at(PairKind kind, const PairPoints& x, const PairPoints& motion, double t) {
  return std::sqrt(squared_pair_distance(kind, x + t * motion));
}
PairPoints points(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d) {
  PairPoints x;
  x << a, b, c, d;
  return x;
}
// The first feature goes by `way`, the second stays.
PairPoints first_moves(PairKind kind, const Vec<3>& way) {
  PairPoints motion = PairPoints::Zero();
  motion.leftCols(kind == PairKind::kPointFace ? 1 : 2).colwise() = way;
  return motion;
}

struct Approach {
  PairKind kind;
  PairPoints points;  // 1 cm above, at y = 0.01
};
const Approach kApproaches[] = {
    {PairKind::kPointFace, points({0.1, 0.01, 0.1}, {0, 0, 0}, {0, 0, 1}, {1, 0, 0})},
    // Over an edge and over a corner.
    {PairKind::kPointFace, points({0, 0.01, 0.3}, {0, 0, 0}, {0, 0, 1}, {1, 0, 0})},
    {PairKind::kPointFace, points({0, 0.01, 0}, {0, 0, 0}, {0, 0, 1}, {1, 0, 0})},
    {PairKind::kEdgeEdge, points({-1, 0.01, 0}, {1, 0.01, 0}, {0, 0, -1}, {0.2, 0, 1})},
    {PairKind::kEdgeEdge, points({-1, 0.01, 0}, {1, 0.01, 0}, {-1, 0, 0}, {1, 0, 0})},  // parallel
};

TEST(FreeMotion, StopsWhatWouldPassThrough) {
  for (const Approach& approach : kApproaches)
    for (const double way : {0.0101, 0.02, 1.0, 1000.0}) {
      const PairPoints motion = first_moves(approach.kind, {0, -way, 0});
      const double t = free_motion(approach.kind, approach.points, motion, kKeep);
      const double left = distance_at(approach.kind, approach.points, motion, t);
      EXPECT_GE(left, kKeep * 0.01);
      EXPECT_LE(left, 1.01 * kKeep * 0.01);  // and no sooner than it must, but for the last advance
    }
}

// Also where it would come to rest beyond, far from where it started.
TEST(FreeMotion, SeesWhatIsPassedOnTheWay) {
  const PairPoints x = points({0.2, 5, 0.2}, {0, 0, 0}, {0, 0, 1}, {1, 0, 0});
  const PairPoints motion = first_moves(PairKind::kPointFace, {0, -10, 0});
  const double t = free_motion(PairKind::kPointFace, x, motion, kKeep);
  EXPECT_NEAR(t, 0.45, 1e-3);
}

TEST(FreeMotion, LetsGoWhatStaysApart) {
  for (const Approach& approach : kApproaches) {
    const auto share = [&](const Vec<3>& way) {
      return free_motion(approach.kind, approach.points, first_moves(approach.kind, way), kKeep);
    };
    EXPECT_EQ(share({0, 0, 0}), 1);
    EXPECT_EQ(share({0, 5, 0}), 1);        // away
    EXPECT_EQ(share({0.03, 0, 0.02}), 1);  // past it
    EXPECT_EQ(share({0, -0.0089, 0}), 1);  // not far enough
    EXPECT_EQ(free_motion(approach.kind, approach.points, PairPoints::Zero(), kKeep), 1);
  }
}

TEST(FreeMotion, CommonMotionDoesNotStop) {
  RandomStream random(1, "common");
  for (const Approach& approach : kApproaches)
    for (int i = 0; i < 20; ++i) {
      const Vec<3> way = random_point(random, 10);
      const PairPoints shift = way.replicate<1, 4>();
      EXPECT_EQ(free_motion(approach.kind, approach.points, shift, kKeep), 1);
      // Turned a little besides, which comes down to cos(angle / 2) of the distance half-way.
      const Vec<3> axis = random_point(random).normalized();
      const Mat<3> turn = Eigen::AngleAxisd(0.1, axis).toRotationMatrix();
      const PairPoints turned = turn * approach.points + shift;
      EXPECT_EQ(free_motion(approach.kind, approach.points, turned - approach.points, kKeep), 1);
    }
}

TEST(FreeMotion, OfWhatTouchesIsNone) {
  PairPoints x = kApproaches[0].points;
  x(1, 0) = 0;
  const PairPoints down = first_moves(PairKind::kPointFace, {0, -1, 0});
  EXPECT_EQ(free_motion(PairKind::kPointFace, x, down, kKeep), 0);
  EXPECT_EQ(free_motion(PairKind::kPointFace, x, PairPoints::Zero(), kKeep), 1);
}

// Judged by 300 instants of the way to t. Where it stops before the end, that is because little is
// left, or because it comes by close.
TEST(FreeMotion, OfRandomMotionsKeepsItsDistance) {
  RandomStream random(2, "motions");
  int stopped = 0, passed = 0, needless = 0;
  for (int i = 0; i < 3000; ++i) {
    PairPoints x, motion;
    for (int k = 0; k < 4; ++k) {
      x.col(k) = random_point(random);
      motion.col(k) = random_point(random, i % 3 + 0.3);
    }
    for (const PairKind kind : {PairKind::kPointFace, PairKind::kEdgeEdge})
      for (const double keep : {0.1, 0.5}) {
        const double start = distance_at(kind, x, motion, 0);
        const double t = free_motion(kind, x, motion, keep);
        ASSERT_GE(t, 0);
        ASSERT_LE(t, 1);
        double least = start;
        for (int k = 1; k <= 300; ++k)
          least = std::min(least, distance_at(kind, x, motion, t * k / 300));
        ASSERT_GE(least, keep * start * (1 - 1e-12));
        if (t == 1) {
          ++passed;
          continue;
        }
        ++stopped;
        needless += distance_at(kind, x, motion, t) > 1.2 * keep * start;
      }
  }
  EXPECT_GT(stopped, 1000);
  EXPECT_GT(passed, 1000);
  EXPECT_LT(needless, stopped / 20);
}

}  // namespace
}  // namespace pleat::sim
