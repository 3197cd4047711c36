#include "body/skinning.h"

#include <gtest/gtest.h>

#include "body/rotation.h"
#include "tests/body/synthetic_body.h"

namespace pleat::body {
namespace {

Eigen::VectorXd some_beta() { return Eigen::Vector3d(0.7, -1.2, 0.4); }

// SMPL as its paper states it (Loper et al. 2015, eqs. 2-10), in homogeneous 4 x 4 matrices and
// Rodrigues' formula.
Points3 smpl_by_the_paper(const BodyModel& model, const Eigen::VectorXd& beta, const Pose& pose) {
  const int joints = model.joint_count();
  Eigen::MatrixXd v = model.template_vertices;
  for (int k = 0; k < beta.size(); ++k) v += beta[k] * Eigen::MatrixXd(model.shape_directions[k]);
  const Eigen::MatrixXd J = Eigen::MatrixXd(model.joint_regressor) * v;
  std::vector<Eigen::Matrix3d> R(joints);
  for (int j = 0; j < joints; ++j) {
    const Eigen::Vector3d w = pose.rotations.row(j);
    const double angle = w.norm();
    Eigen::Matrix3d K;
    K << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
    K /= angle;
    R[j] = Eigen::Matrix3d::Identity() + std::sin(angle) * K + (1 - std::cos(angle)) * K * K;
  }
  for (int i = 0; i < v.rows(); ++i) {
    for (int c = 0; c < 3; ++c) {
      for (int j = 1; j < joints; ++j) {
        for (int a = 0; a < 3; ++a) {
          for (int b = 0; b < 3; ++b) {
            v(i, c) += model.pose_directions(3 * i + c, 9 * (j - 1) + 3 * a + b) *
                       (R[j](a, b) - (a == b ? 1 : 0));
          }
        }
      }
    }
  }
  std::vector<Eigen::Matrix4d> G(joints);
  for (int j = 0; j < joints; ++j) {
    const int parent = model.parents[j];
    Eigen::Matrix4d local = Eigen::Matrix4d::Identity();
    local.topLeftCorner<3, 3>() = R[j];
    local.topRightCorner<3, 1>() = J.row(j).transpose();
    if (parent >= 0) local.topRightCorner<3, 1>() -= J.row(parent).transpose();
    G[j] = parent < 0 ? local : Eigen::Matrix4d(G[parent] * local);
  }
  Points3 posed(v.rows(), 3);
  for (int i = 0; i < v.rows(); ++i) {
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (int j = 0; j < joints; ++j) {
      Eigen::Matrix4d to_joint = Eigen::Matrix4d::Identity();
      to_joint.topRightCorner<3, 1>() = -J.row(j).transpose();
      const Eigen::Vector4d x(v(i, 0), v(i, 1), v(i, 2), 1);
      sum += model.weights.coeff(i, j) * (G[j] * (to_joint * x));
    }
    posed.row(i) = sum.head<3>().transpose() + pose.translation.transpose();
  }
  return posed;
}

TEST(Skinning, WithoutBindPoseIsSmpl) {
  BodyModel model = box_body();
  add_pose_directions(model);
  RandomStream random(1, "pose");
  for (int k = 0; k < 5; ++k) {
    const Pose pose = random_pose(random, 0.6);
    const Points3 posed = pose_body(model, shape_body(model, some_beta()), pose);
    EXPECT_LT((posed - smpl_by_the_paper(model, some_beta(), pose)).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(Skinning, BindPoseLeavesTheTemplateAsItIs) {
  BodyModel model = box_body();
  bind_in_a_pose(model);
  const ShapedBody body = shape_body(model, some_beta());
  Pose bind;
  bind.rotations = model.bind_pose;
  EXPECT_LT((pose_body(model, body, bind) - body.vertices).cwiseAbs().maxCoeff(), 1e-12);
}

// Joints that the posed vertices carry: forward kinematics puts them where the regressor has them
// in the bind pose.
TEST(Skinning, BindPoseJointsAreTheRegressedOnes) {
  BodyModel model = box_body();
  bind_in_a_pose(model);
  const ShapedBody body = shape_body(model, some_beta());
  Pose bind;
  bind.rotations = model.bind_pose;
  const std::vector<Transform> transforms = joint_transforms(model, body, bind);
  const Points3 regressed = model.joint_regressor * body.vertices;
  for (int j = 0; j < kJoints; ++j) {
    const Vec<3> joint =
        transforms[j].leftCols<3>() * body.joints.row(j).transpose() + transforms[j].col(3);
    EXPECT_LT((joint - regressed.row(j).transpose()).norm(), 1e-12) << kJointNames[j];
  }
}

TEST(Skinning, RootTurnsTheWholeBodyAboutItsJoint) {
  BodyModel model = box_body();
  bind_in_a_pose(model);
  const ShapedBody body = shape_body(model, some_beta());
  RandomStream random(2, "pose");
  Pose pose = random_pose(random, 0.5);
  pose.rotations.row(0).setZero();
  pose.translation.setZero();
  const Points3 before = pose_body(model, body, pose);
  pose.rotations.row(0) << 0.4, -1.1, 0.3;
  pose.translation << 1, 2, 3;
  const Points3 after = pose_body(model, body, pose);
  const Mat<3> R = rotation_matrix(pose.rotations.row(0));
  const Eigen::RowVector3d root = body.joints.row(0);
  const Points3 expected =
      (((before.rowwise() - root) * R.transpose()).rowwise() + root).rowwise() +
      pose.translation.transpose();
  EXPECT_LT((after - expected).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Skinning, FingersOfLargerModelsStayAtRest) {
  const BodyModel model = box_body(55);
  Pose pose;
  pose.rotations.row(22) << 0, 0, 1;
  pose.rotations.row(23) << 0, 0, -1;
  const ShapedBody body = shape_body(model, some_beta());
  EXPECT_LT((pose_body(model, body, pose) - body.vertices).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Unskin, UndoesSkinning) {
  const BodyModel model = box_body();
  const ShapedBody body = shape_body(model, some_beta());
  RandomStream random(3, "pose");
  for (int k = 0; k < 5; ++k) {
    const std::vector<Transform> transforms =
        joint_transforms(model, body, random_pose(random, 0.3));
    Eigen::VectorXd singular;
    const Points3 linear = skin_linear(body.vertices, model.weights, transforms);
    EXPECT_LT((unskin_linear(linear, model.weights, transforms, &singular) - body.vertices)
                  .cwiseAbs()
                  .maxCoeff(),
              1e-10);
    EXPECT_GT(singular.minCoeff(), 0);
    EXPECT_LE(singular.maxCoeff(), 1 + 1e-12);
    const Points3 dual = skin_dual_quaternion(body.vertices, model.weights, transforms);
    EXPECT_LT((unskin_dual_quaternion(dual, model.weights, transforms) - body.vertices)
                  .cwiseAbs()
                  .maxCoeff(),
              1e-12);
  }
}

TEST(Unskin, SingularValueSeesACandyWrapper) {
  SkinWeights weights(1, 2);
  weights.insert(0, 0) = 0.5;
  weights.insert(0, 1) = 0.5;
  std::vector<Transform> transforms(2, Transform::Zero());
  transforms[0].leftCols<3>() = Mat<3>::Identity();
  transforms[1].leftCols<3>() = rotation_matrix({M_PI, 0, 0});
  Eigen::VectorXd singular;
  unskin_linear(Points3::Zero(1, 3), weights, transforms, &singular);
  EXPECT_LT(singular[0], 1e-7);
  transforms[1].leftCols<3>() = rotation_matrix({M_PI / 2, 0, 0});
  unskin_linear(Points3::Zero(1, 3), weights, transforms, &singular);
  EXPECT_NEAR(singular[0], std::sqrt(0.5), 1e-12);
}

// Half of a turn about one axis and half of none is half the turn, without loss of volume (Kavan et
// al. 2007).
TEST(DualQuaternions, BlendOfTwoTurnsIsTheTurnBetween) {
  SkinWeights weights(1, 2);
  weights.insert(0, 0) = 0.5;
  weights.insert(0, 1) = 0.5;
  std::vector<Transform> transforms(2, Transform::Zero());
  transforms[0].leftCols<3>() = Mat<3>::Identity();
  transforms[1].leftCols<3>() = rotation_matrix({0, 0, 2.8});
  Points3 point(1, 3);
  point << 1, 2, 3;
  const Points3 skinned = skin_dual_quaternion(point, weights, transforms);
  EXPECT_LT(
      (skinned.row(0).transpose() - rotation_matrix({0, 0, 1.4}) * point.row(0).transpose()).norm(),
      1e-12);
}

}  // namespace
}  // namespace pleat::body
