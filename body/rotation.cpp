#include "body/rotation.h"

#include <Eigen/Geometry>

namespace pleat::body {
namespace {

Eigen::Quaterniond quaternion(const Vec<3>& axis_angle) {
  const double angle = axis_angle.norm();
  if (angle < 1e-12)
    return Eigen::Quaterniond(1, axis_angle.x() / 2, axis_angle.y() / 2, axis_angle.z() / 2);
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis_angle / angle));
}

Vec<3> axis_angle_of(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0 ? -1 : 1;
  const double sine = q.vec().norm();
  if (sine < 1e-12) return sign * 2 * q.vec();
  return sign * 2 * std::atan2(sine, std::abs(q.w())) / sine * q.vec();
}

}  // namespace

Mat<3> rotation_matrix(const Vec<3>& axis_angle) {
  return quaternion(axis_angle).toRotationMatrix();
}

Vec<3> axis_angle(const Mat<3>& rotation) { return axis_angle_of(Eigen::Quaterniond(rotation)); }

double angle_between(const Vec<3>& axis_angle_a, const Vec<3>& axis_angle_b) {
  return quaternion(axis_angle_a).angularDistance(quaternion(axis_angle_b));
}

Mat<3> rotation_between(const Vec<3>& from, const Vec<3>& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
}

Vec<3> slerp(const Vec<3>& axis_angle_a, const Vec<3>& axis_angle_b, double t) {
  if (t == 0) return axis_angle_a;
  if (t == 1) return axis_angle_b;
  return axis_angle_of(quaternion(axis_angle_a).slerp(t, quaternion(axis_angle_b)));
}

}  // namespace pleat::body
