// Linear blend and dual quaternion skinning, and their inverse, for the body and for what it wears.
#pragma once

#include <vector>

#include "body/body_model.h"
#include "body/motion.h"

namespace pleat::body {

using Transform = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;  // [R | t]: x -> R x + t

// For each joint, from the T-pose of this shape (root joint where the shape puts it, untranslated)
// to the posed world: x_posed = R x_T + t. Joints above kJoints (fingers, face) stay at rest.
std::vector<Transform> joint_transforms(const BodyModel& model, const ShapedBody& body,
                                        const Pose& pose);

// The same from the bind pose, in which the model's vertices stand, to the posed world.
std::vector<Transform> bind_to_pose(const BodyModel& model, const ShapedBody& body,
                                    const Pose& pose);

// The body's surface in the pose: bind pose -> T-pose -> pose, with pose blend shapes where the
// model has them.
Points3 pose_body(const BodyModel& model, const ShapedBody& body, const Pose& pose);

// Points in the T-pose to the posed world, each with its blend of transforms (row of weights). And
// back.
Points3 skin_linear(const Eigen::Ref<const Points3>& points, const SkinWeights& weights,
                    const std::vector<Transform>& transforms);
// smallest_singular_value, where given, receives for each point that of the blended linear part (1:
// rigid, 0: not invertible).
Points3 unskin_linear(const Eigen::Ref<const Points3>& posed, const SkinWeights& weights,
                      const std::vector<Transform>& transforms,
                      Eigen::VectorXd* smallest_singular_value = nullptr);
// Kavan et al. 2007.
Points3 skin_dual_quaternion(const Eigen::Ref<const Points3>& points, const SkinWeights& weights,
                             const std::vector<Transform>& transforms);
Points3 unskin_dual_quaternion(const Eigen::Ref<const Points3>& posed, const SkinWeights& weights,
                               const std::vector<Transform>& transforms);

}  // namespace pleat::body
