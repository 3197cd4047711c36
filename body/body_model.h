// A parametric human body in SMPL's form (Loper et al. 2015): template + shape directions, joints
// regressed from the vertices, linear blend skinning.
//
// One extension: the template may stand in another pose than the T-pose (`bind_pose`), because a
// body bound in an A-pose overlaps itself far less with the arms down. With bind_pose = 0 this is
// SMPL exactly.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/types.h"

namespace pleat::body {

constexpr int kJoints = 24;
constexpr std::array<const char*, kJoints> kJointNames = {
    "pelvis",     "left_hip",    "right_hip",    "spine1",      "left_knee",     "right_knee",
    "spine2",     "left_ankle",  "right_ankle",  "spine3",      "left_foot",     "right_foot",
    "neck",       "left_collar", "right_collar", "head",        "left_shoulder", "right_shoulder",
    "left_elbow", "right_elbow", "left_wrist",   "right_wrist", "left_hand",     "right_hand"};
constexpr std::array<int, kJoints> kParents = {-1, 0, 0, 0,  1,  2,  3,  4,  5,  6,  7,  8,
                                               9,  9, 9, 12, 13, 14, 16, 17, 18, 19, 20, 21};

struct BodyModel {
  std::string name;
  Points3 template_vertices;              // #V x 3, m, bind pose, y up, facing +z
  std::vector<Points3> shape_directions;  // each #V x 3, m per unit of beta
  Eigen::MatrixXd pose_directions;        // 3#V x 9(J-1), row 3v+c; empty where the model has none
  SkinWeights joint_regressor;            // J x #V, rows sum to 1
  SkinWeights weights;                    // #V x J
  Eigen::VectorXi parents;                // J, parents[0] = -1, parents[j] < j
  Points3 bind_pose;  // J x 3, axis-angle, rad: local rotations in which the template stands
  Faces faces;        // #F x 3, outward

  int joint_count() const { return static_cast<int>(parents.size()); }
};

// The body of one shape.
struct ShapedBody {
  Points3 vertices;  // #V x 3, m, bind pose
  Points3 joints;    // J x 3, m, T-pose (all joint rotations zero), body frame
};

// beta may be shorter than the model's directions; missing ones are 0. Longer is an InputError.
ShapedBody shape_body(const BodyModel& model, const Eigen::Ref<const Eigen::VectorXd>& beta);

// Throws InputError, naming `source` and the array, where shapes disagree, numbers are not finite,
// weights do not sum to 1, the tree is not a tree, or the surface is not watertight.
void validate(const BodyModel& model, const std::string& source);

}  // namespace pleat::body
