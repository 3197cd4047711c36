#include "learn/condition.h"

#include <Eigen/Geometry>

namespace pleat::learn {
namespace {

Mat<3> rotation_matrix(const Vec<3>& axis_angle) {
  const double angle = axis_angle.norm();
  if (angle < 1e-12) return Mat<3>::Identity();
  return Eigen::AngleAxisd(angle, axis_angle / angle).toRotationMatrix();
}

}  // namespace

int64_t feature_count(int64_t joints, int64_t shape_count) {
  return 3 + 6 * (joints - 1) + shape_count + 3;
}

Eigen::VectorXf condition_features(const Condition& condition) {
  const int64_t joints = condition.pose.rows();
  Eigen::VectorXd features(feature_count(joints, condition.shape.size()));
  const Vec<3> down(0, -1, 0);
  features.head<3>() = rotation_matrix(condition.pose.row(0).transpose()).transpose() * down;
  for (int64_t j = 1; j < joints; ++j) {
    const Mat<3> turn = rotation_matrix(condition.pose.row(j).transpose()) - Mat<3>::Identity();
    features.segment<3>(3 + 6 * (j - 1)) = turn.col(0);
    features.segment<3>(6 + 6 * (j - 1)) = turn.col(1);
  }
  features.segment(3 + 6 * (joints - 1), condition.shape.size()) = condition.shape;
  features.tail<3>() = condition.design;
  return features.cast<float>();
}

}  // namespace pleat::learn
