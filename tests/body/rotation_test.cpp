#include "body/rotation.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "core/random.h"

namespace pleat::body {
namespace {

TEST(Rotation, AxisAngleRoundTrip) {
  RandomStream random(1, "rotation");
  for (int k = 0; k < 200; ++k) {
    Vec<3> r(random.normal(), random.normal(), random.normal());
    if (k % 4 == 0) r *= 1e-9;
    if (r.norm() > M_PI) r *= M_PI * random.uniform() / r.norm();
    EXPECT_LT((axis_angle(rotation_matrix(r)) - r).norm(), 1e-9 + 1e-7 * r.norm());
    EXPECT_NEAR(rotation_matrix(r).determinant(), 1, 1e-12);
  }
}

TEST(Rotation, BetweenTurnsOneDirectionIntoTheOther) {
  const Vec<3> a(1, 2, -0.5), b(-3, 0.2, 1);
  EXPECT_LT((rotation_between(a, b) * a.normalized() - b.normalized()).norm(), 1e-12);
  EXPECT_LT((rotation_between(a, -a) * a.normalized() + a.normalized()).norm(),
            1e-6);  // half a turn, any axis
}

TEST(Rotation, SlerpTakesTheShortestWay) {
  const Vec<3> a(0, 0, 3), b(0, 0, -3);  // 0.283 rad apart, across pi
  EXPECT_NEAR(angle_between(a, slerp(a, b, 0.5)), M_PI - 3, 1e-9);
  EXPECT_NEAR(angle_between(a, b), 2 * (M_PI - 3), 1e-9);
  EXPECT_EQ(slerp(a, b, 0), a);
  EXPECT_EQ(slerp(a, b, 1), b);
}

}  // namespace
}  // namespace pleat::body
