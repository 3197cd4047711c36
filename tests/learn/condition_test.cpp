#include "learn/condition.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

namespace pleat::learn {
namespace {

Condition some_condition() {
  Condition condition;
  condition.pose = Points3::Zero(24, 3);
  condition.pose.row(0) << 0.3, 0.7, -0.2;
  condition.pose.row(5) << 1.1, -0.4, 0.6;
  condition.shape = Eigen::VectorXd::LinSpaced(10, -1, 1);
  condition.design << 0.2, 0.5, 0.9;
  return condition;
}

Vec<3> axis_angle(const Mat<3>& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

TEST(Condition, CountsItsFeatures) {
  EXPECT_EQ(condition_features(some_condition()).size(), feature_count(24, 10));
  EXPECT_EQ(feature_count(24, 10), 3 + 23 * 6 + 10 + 3);
}

TEST(Condition, IgnoresHeadingButNotLeaning) {
  const Condition condition = some_condition();
  const Vec<3> root = condition.pose.row(0).transpose();
  const Mat<3> turn = Eigen::AngleAxisd(root.norm(), root.normalized()).toRotationMatrix();
  Condition turned = condition;
  turned.pose.row(0) =
      axis_angle(Eigen::AngleAxisd(1.3, Vec<3>::UnitY()).toRotationMatrix() * turn).transpose();
  EXPECT_LT((condition_features(turned) - condition_features(condition)).norm(), 1e-6);
  turned.pose.row(0) =
      axis_angle(Eigen::AngleAxisd(0.3, Vec<3>::UnitX()).toRotationMatrix() * turn).transpose();
  EXPECT_GT((condition_features(turned) - condition_features(condition)).norm(), 0.1);
}

// pi and -pi about the same axis are one rotation: raw axis-angle would differ by 2 pi.
TEST(Condition, IsContinuousWhereAxisAngleJumps) {
  Condition a = some_condition(), b = a;
  a.pose.row(3) << M_PI - 1e-4, 0, 0;
  b.pose.row(3) << -M_PI + 1e-4, 0, 0;
  EXPECT_LT((condition_features(a) - condition_features(b)).norm(), 1e-3);
}

TEST(Condition, IsZeroForJointsAtRest) {
  Condition condition = some_condition();
  condition.pose.setZero();
  const Eigen::VectorXf features = condition_features(condition);
  EXPECT_EQ(features[1], -1);  // gravity
  EXPECT_EQ(features.segment(3, 23 * 6).norm(), 0);
}

}  // namespace
}  // namespace pleat::learn
