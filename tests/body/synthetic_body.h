// A box with a human skeleton inside: every part of an SMPL-format model, small and without data
// files.
#pragma once

#include <algorithm>
#include <cmath>

#include "body/body_model.h"
#include "body/motion.h"
#include "core/mesh.h"
#include "core/random.h"

namespace pleat::body {

inline Points3 human_joints() {
  Points3 joints(kJoints, 3);
  joints << 0, 0, 0, 0.1, -0.05, 0, -0.1, -0.05, 0, 0, 0.1, -0.02, 0.12, -0.45, 0, -0.12, -0.45, 0,
      0, 0.22, -0.02,  //
      0.12, -0.85, -0.03, -0.12, -0.85, -0.03, 0, 0.3, 0, 0.13, -0.9, 0.1, -0.13, -0.9, 0.1, 0, 0.5,
      -0.02,  //
      0.08, 0.42, -0.02, -0.08, 0.42, -0.02, 0, 0.58, 0.02, 0.18, 0.43, -0.02, -0.18, 0.43,
      -0.02,  //
      0.45, 0.43, -0.02, -0.45, 0.43, -0.02, 0.68, 0.43, -0.02, -0.68, 0.43, -0.02, 0.75, 0.43, 0,
      -0.75, 0.43, 0;
  return joints;
}

inline Pose random_pose(RandomStream& random, double angle) {
  Pose pose;
  for (int i = 0; i < pose.rotations.size(); ++i)
    pose.rotations.data()[i] = angle * random.normal();
  for (int c = 0; c < 3; ++c) pose.translation[c] = random.normal();
  return pose;
}

// Corner k: x, y, z from its bits.
constexpr double kBoxLow[3] = {-0.9, -1, -0.25}, kBoxHigh[3] = {0.9, 0.85, 0.3};

inline TriangleMesh box_mesh(int subdivisions) {
  TriangleMesh mesh;
  mesh.vertices.resize(8, 3);
  for (int k = 0; k < 8; ++k) {
    for (int c = 0; c < 3; ++c) mesh.vertices(k, c) = (k >> c) & 1 ? kBoxHigh[c] : kBoxLow[c];
  }
  mesh.faces.resize(12, 3);
  mesh.faces << 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2,
      4, 6, 1, 3, 5, 3, 7, 5;
  for (int k = 0; k < subdivisions; ++k) mesh = subdivide(mesh);
  return mesh;
}

// joint_count above 24: further joints hang on the head, as SMPL-X's jaw and eyes.
inline BodyModel box_body(int joint_count = kJoints) {
  RandomStream random(7, "box");
  const TriangleMesh mesh = box_mesh(3);
  BodyModel model;
  model.name = "box";
  model.template_vertices = mesh.vertices;
  model.faces = mesh.faces;
  const Eigen::Index vertices = mesh.vertices.rows();

  Points3 joints(joint_count, 3);
  joints.topRows(kJoints) = human_joints();
  model.parents.resize(joint_count);
  for (int j = 0; j < joint_count; ++j) model.parents[j] = j < kJoints ? kParents[j] : 15;
  for (int j = 22; j < joint_count && joint_count > kJoints; ++j) {
    model.parents[j] = 15;
    joints.row(j) << 0.02 * (j % 3 - 1), 0.7, 0.1;
  }

  for (int k = 0; k < 3; ++k) {  // beta_k stretches along axis k by a tenth
    Points3 direction = Points3::Zero(vertices, 3);
    direction.col(k) = 0.1 * mesh.vertices.col(k);
    model.shape_directions.push_back(direction);
  }

  // A joint is where trilinear interpolation of the box's corners puts it.
  std::vector<Eigen::Triplet<double>> regressor, weights;
  for (int j = 0; j < joint_count; ++j) {
    for (int k = 0; k < 8; ++k) {
      double weight = 1;
      for (int c = 0; c < 3; ++c) {
        const double t = (joints(j, c) - kBoxLow[c]) / (kBoxHigh[c] - kBoxLow[c]);
        weight *= (k >> c) & 1 ? t : 1 - t;
      }
      regressor.emplace_back(j, k, weight);
    }
  }
  model.joint_regressor.resize(joint_count, vertices);
  model.joint_regressor.setFromTriplets(regressor.begin(), regressor.end());

  for (Eigen::Index v = 0; v < vertices; ++v) {  // the four nearest joints
    std::vector<std::pair<double, int>> nearest;
    for (int j = 0; j < joint_count; ++j) {
      nearest.emplace_back((joints.row(j) - mesh.vertices.row(v)).squaredNorm(), j);
    }
    std::sort(nearest.begin(), nearest.end());
    nearest.resize(4);
    double sum = 0;
    for (const auto& [squared, j] : nearest) sum += 1 / squared;
    for (const auto& [squared, j] : nearest) weights.emplace_back(v, j, 1 / squared / sum);
  }
  model.weights.resize(vertices, joint_count);
  model.weights.setFromTriplets(weights.begin(), weights.end());
  model.bind_pose = Points3::Zero(joint_count, 3);
  return model;
}

inline void add_pose_directions(BodyModel& model) {
  RandomStream random(7, "pose directions");
  model.pose_directions.resize(3 * model.template_vertices.rows(), 9 * (model.joint_count() - 1));
  for (Eigen::Index i = 0; i < model.pose_directions.size(); ++i)
    model.pose_directions.data()[i] = 0.01 * random.normal();
}

// Arms 40 degrees down.
inline void bind_in_a_pose(BodyModel& model) {
  model.bind_pose.row(16) << 0, 0, -0.7;
  model.bind_pose.row(17) << 0, 0, 0.7;
  model.bind_pose.row(18) << 0.1, -0.3, 0;
}

}  // namespace pleat::body
