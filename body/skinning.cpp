#include "body/skinning.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "body/rotation.h"

namespace pleat::body {
namespace {

// Forward kinematics: T-pose of this shape -> pose given by one local rotation a joint.
std::vector<Transform> chain(const Eigen::VectorXi& parents, const Points3& joints,
                             const Points3& rotations, const Vec<3>& translation) {
  std::vector<Transform> transforms(static_cast<size_t>(parents.size()));
  for (int j = 0; j < parents.size(); ++j) {
    const Mat<3> local = rotation_matrix(rotations.row(j));
    const Vec<3> joint = joints.row(j);
    Transform& transform = transforms[j];
    if (parents[j] < 0) {
      transform.leftCols<3>() = local;
      transform.col(3) = joint - local * joint + translation;
    } else {
      const Transform& parent = transforms[parents[j]];
      transform.leftCols<3>() = parent.leftCols<3>() * local;
      transform.col(3) =
          parent.leftCols<3>() * joint + parent.col(3) - transform.leftCols<3>() * joint;
    }
  }
  return transforms;
}

// Rotations of all the model's joints. SMPL+H and SMPL-X share joints 0..21 with SMPL; theirs from
// 22 on are fingers and face, which SMPL's hands (22, 23) must not drive.
Points3 model_rotations(const BodyModel& model, const Pose& pose) {
  Points3 rotations = Points3::Zero(model.joint_count(), 3);
  const int driven = model.joint_count() <= kJoints ? model.joint_count() : 22;
  rotations.topRows(driven) = pose.rotations.topRows(driven);
  return rotations;
}

Transform inverse(const Transform& transform) {
  Transform result;
  result.leftCols<3>() = transform.leftCols<3>().transpose();
  result.col(3) = -result.leftCols<3>() * transform.col(3);
  return result;
}

Transform compose(const Transform& a, const Transform& b) {
  Transform result;
  result.leftCols<3>() = a.leftCols<3>() * b.leftCols<3>();
  result.col(3) = a.leftCols<3>() * b.col(3) + a.col(3);
  return result;
}

Transform blend_linear(const SkinWeights& weights, int row,
                       const std::vector<Transform>& transforms) {
  Transform blended = Transform::Zero();
  for (SkinWeights::InnerIterator it(weights, row); it; ++it)
    blended += it.value() * transforms[it.col()];
  return blended;
}

// Rows: real part (w, x, y, z), dual part.
using DualQuaternion = Eigen::Matrix<double, 2, 4, Eigen::RowMajor>;

std::vector<DualQuaternion> dual_quaternions(const std::vector<Transform>& transforms) {
  std::vector<DualQuaternion> result(transforms.size());
  for (size_t j = 0; j < transforms.size(); ++j) {
    const Eigen::Quaterniond q(Mat<3>(transforms[j].leftCols<3>()));
    const Vec<3> t = transforms[j].col(3);
    const Eigen::Quaterniond dual = Eigen::Quaterniond(0, t.x(), t.y(), t.z()) * q;
    result[j] << q.w(), q.x(), q.y(), q.z(), dual.w() / 2, dual.x() / 2, dual.y() / 2, dual.z() / 2;
  }
  return result;
}

// Blend of unit dual quaternions, normalised; each is first flipped to the hemisphere of the
// heaviest one.
Transform blend_dual_quaternion(const SkinWeights& weights, int row,
                                const std::vector<DualQuaternion>& joints) {
  int heaviest = -1;
  double largest = -1;
  for (SkinWeights::InnerIterator it(weights, row); it; ++it) {
    if (it.value() > largest) largest = it.value(), heaviest = static_cast<int>(it.col());
  }
  DualQuaternion blended = DualQuaternion::Zero();
  for (SkinWeights::InnerIterator it(weights, row); it; ++it) {
    const double sign = joints[it.col()].row(0).dot(joints[heaviest].row(0)) < 0 ? -1 : 1;
    blended += sign * it.value() * joints[it.col()];
  }
  blended /= blended.row(0).norm();
  const Eigen::Quaterniond q(blended(0, 0), blended(0, 1), blended(0, 2), blended(0, 3));
  const Eigen::Quaterniond dual(blended(1, 0), blended(1, 1), blended(1, 2), blended(1, 3));
  Transform result;
  result.leftCols<3>() = q.toRotationMatrix();
  result.col(3) = 2 * (dual * q.conjugate()).vec();
  return result;
}

void check_sizes(const Eigen::Ref<const Points3>& points, const SkinWeights& weights,
                 const std::vector<Transform>& transforms) {
  assert(points.rows() == weights.rows());
  assert(weights.cols() == static_cast<Eigen::Index>(transforms.size()));
  (void)points, (void)weights, (void)transforms;
}

}  // namespace

std::vector<Transform> joint_transforms(const BodyModel& model, const ShapedBody& body,
                                        const Pose& pose) {
  return chain(model.parents, body.joints, model_rotations(model, pose), pose.translation);
}

std::vector<Transform> bind_to_pose(const BodyModel& model, const ShapedBody& body,
                                    const Pose& pose) {
  std::vector<Transform> transforms = joint_transforms(model, body, pose);
  const std::vector<Transform> bind =
      chain(model.parents, body.joints, model.bind_pose, Vec<3>::Zero());
  for (size_t j = 0; j < transforms.size(); ++j)
    transforms[j] = compose(transforms[j], inverse(bind[j]));
  return transforms;
}

Points3 pose_body(const BodyModel& model, const ShapedBody& body, const Pose& pose) {
  Points3 vertices = body.vertices;
  if (model.pose_directions.size() > 0) {
    const Points3 rotations = model_rotations(model, pose);
    Eigen::VectorXd feature(9 * (model.joint_count() - 1));  // (R_j - I) row by row, j = 1 ..
    for (int j = 1; j < model.joint_count(); ++j) {
      const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> difference =
          rotation_matrix(rotations.row(j)) - Mat<3>::Identity();
      feature.segment<9>(9 * (j - 1)) = Eigen::Map<const Vec<9>>(difference.data());
    }
    Eigen::Map<Eigen::VectorXd>(vertices.data(), vertices.size()) +=
        model.pose_directions * feature;
  }
  return skin_linear(vertices, model.weights, bind_to_pose(model, body, pose));
}

Points3 skin_linear(const Eigen::Ref<const Points3>& points, const SkinWeights& weights,
                    const std::vector<Transform>& transforms) {
  check_sizes(points, weights, transforms);
  Points3 result(points.rows(), 3);
  for (int i = 0; i < points.rows(); ++i) {
    const Transform blended = blend_linear(weights, i, transforms);
    result.row(i) =
        (blended.leftCols<3>() * points.row(i).transpose() + blended.col(3)).transpose();
  }
  return result;
}

Points3 unskin_linear(const Eigen::Ref<const Points3>& posed, const SkinWeights& weights,
                      const std::vector<Transform>& transforms,
                      Eigen::VectorXd* smallest_singular_value) {
  check_sizes(posed, weights, transforms);
  Points3 result(posed.rows(), 3);
  if (smallest_singular_value) smallest_singular_value->resize(posed.rows());
  for (int i = 0; i < posed.rows(); ++i) {
    const Transform blended = blend_linear(weights, i, transforms);
    const Mat<3> linear = blended.leftCols<3>();
    const Vec<3> difference = posed.row(i).transpose() - blended.col(3);
    result.row(i) = linear.partialPivLu().solve(difference).transpose();
    if (smallest_singular_value) {
      const Eigen::SelfAdjointEigenSolver<Mat<3>> squares(linear.transpose() * linear,
                                                          Eigen::EigenvaluesOnly);
      (*smallest_singular_value)[i] = std::sqrt(std::max(0.0, squares.eigenvalues()[0]));
    }
  }
  return result;
}

Points3 skin_dual_quaternion(const Eigen::Ref<const Points3>& points, const SkinWeights& weights,
                             const std::vector<Transform>& transforms) {
  check_sizes(points, weights, transforms);
  const std::vector<DualQuaternion> joints = dual_quaternions(transforms);
  Points3 result(points.rows(), 3);
  for (int i = 0; i < points.rows(); ++i) {
    const Transform blended = blend_dual_quaternion(weights, i, joints);
    result.row(i) =
        (blended.leftCols<3>() * points.row(i).transpose() + blended.col(3)).transpose();
  }
  return result;
}

Points3 unskin_dual_quaternion(const Eigen::Ref<const Points3>& posed, const SkinWeights& weights,
                               const std::vector<Transform>& transforms) {
  check_sizes(posed, weights, transforms);
  const std::vector<DualQuaternion> joints = dual_quaternions(transforms);
  Points3 result(posed.rows(), 3);
  for (int i = 0; i < posed.rows(); ++i) {
    const Transform back = inverse(blend_dual_quaternion(weights, i, joints));
    result.row(i) = (back.leftCols<3>() * posed.row(i).transpose() + back.col(3)).transpose();
  }
  return result;
}

}  // namespace pleat::body
