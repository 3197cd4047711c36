#include <gtest/gtest.h>

#include "evaluate/diversity.h"
#include "evaluate/velocity_error.h"
#include "evaluate/vertex_error.h"

namespace pleat::evaluate {
namespace {

Points3 line(int count) {
  Points3 points = Points3::Zero(count, 3);
  for (int i = 0; i < count; ++i) points.row(i) << 0.01 * i, 1, -2;
  return points;
}

TEST(VertexError, OfAKnownShiftIsThatShiftInMillimetres) {
  Points3 moved = line(100);
  moved.rowwise() += Eigen::RowVector3d(0.003, 0, 0.004);
  const VertexError error = vertex_error(moved, line(100));
  EXPECT_NEAR(error.mean_mm, 5, 1e-9);
  EXPECT_NEAR(error.p95_mm, 5, 1e-9);
  EXPECT_NEAR(error.max_mm, 5, 1e-9);
}

TEST(VertexError, PercentileLeavesTheWorstOut) {
  Points3 moved = line(100);
  for (int i = 0; i < 100; ++i) moved(i, 1) += 0.001 * (i + 1);
  const VertexError error = vertex_error(moved, line(100));
  EXPECT_NEAR(error.mean_mm, 50.5, 1e-9);
  EXPECT_NEAR(error.p95_mm, 95, 1e-9);
  EXPECT_NEAR(error.max_mm, 100, 1e-9);
}

TEST(VelocityError, IgnoresAShiftThatLasts) {
  const Points3 before = line(10);
  Points3 after = before;
  after.col(1).array() += 0.02;
  Points3 shifted_before = before, shifted_after = after;
  shifted_before.col(0).array() += 0.1;
  shifted_after.col(0).array() += 0.1;
  EXPECT_NEAR(velocity_error_mm_per_s(shifted_before, shifted_after, before, after, 30), 0, 1e-9);
}

TEST(VelocityError, CountsFlicker) {
  const Points3 before = line(10);
  Points3 flickered = before;
  flickered.col(2).array() += 0.001;
  EXPECT_NEAR(velocity_error_mm_per_s(before, flickered, before, before, 30), 30, 1e-9);
}

TEST(Diversity, IsTheSpreadRoundTheMean) {
  Points3 low = line(10), high = line(10);
  low.col(0).array() -= 0.002;
  high.col(0).array() += 0.002;
  EXPECT_NEAR(spread_mm({low, high}), 2, 1e-9);
  EXPECT_NEAR(spread_mm({low, low, low}), 0, 1e-9);
}

}  // namespace
}  // namespace pleat::evaluate
