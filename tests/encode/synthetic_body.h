// A body for the tube to be worn by: a closed column with SMPL's joint tree inside, and clips of
// the two.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "body/body_model.h"
#include "body/motion.h"
#include "body/skinning.h"
#include "garment/clip.h"
#include "garment/template.h"
#include "tests/encode/synthetic.h"

namespace pleat::encode {

constexpr int kParents[body::kJoints] = {-1, 0, 0, 0,  1,  2,  3,  4,  5,  6,  7,  8,
                                         9,  9, 9, 12, 13, 14, 16, 17, 18, 19, 20, 21};
constexpr int kSpine[] = {0, 3,  6,
                          9, 12, 15};  // pelvis to head, the only joints that the column follows

// Weights on the spine for a point at this height in 0 .. 0.8 m.
inline SkinWeights spine_weights(const Eigen::VectorXd& heights) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int v = 0; v < heights.size(); ++v) {
    const double at = std::clamp(heights[v] / 0.8, 0.0, 1.0) * 5;
    const int below = std::min(4, static_cast<int>(at));
    if (at - below < 1) entries.emplace_back(v, kSpine[below], 1 - (at - below));
    if (at - below > 0) entries.emplace_back(v, kSpine[below + 1], at - below);
  }
  SkinWeights weights(heights.size(), body::kJoints);
  weights.setFromTriplets(entries.begin(), entries.end());
  return weights;
}

// A column of radius 0.15 m from y = 0 to 0.8 m; beta_0 widens it by 1 cm, beta_1 lifts it.
inline body::BodyModel column_body() {
  constexpr int kAround = 12, kRings = 6;
  body::BodyModel model;
  model.name = "column";
  const int count = kAround * kRings + 2;
  model.template_vertices = Points3::Zero(count, 3);
  model.shape_directions.assign(2, Points3::Zero(count, 3));
  model.shape_directions[1].col(1).setConstant(0.01);
  for (int r = 0; r < kRings; ++r) {
    for (int a = 0; a < kAround; ++a) {
      const double angle = 2 * M_PI * a / kAround;
      const Eigen::RowVector3d out(std::cos(angle), 0, std::sin(angle));
      model.template_vertices.row(r * kAround + a) =
          0.15 * out + Eigen::RowVector3d(0, 0.8 * r / (kRings - 1), 0);
      model.shape_directions[0].row(r * kAround + a) = 0.01 * out;
    }
  }
  const int bottom = kAround * kRings, top = bottom + 1;
  model.template_vertices(top, 1) = 0.8;
  std::vector<Eigen::Vector3i> faces;
  for (int a = 0; a < kAround; ++a) {
    const int b = (a + 1) % kAround;
    for (int r = 0; r + 1 < kRings; ++r) {
      const int low = r * kAround, high = low + kAround;
      faces.emplace_back(low + a, high + a, low + b);
      faces.emplace_back(low + b, high + a, high + b);
    }
    faces.emplace_back(bottom, a, b);
    faces.emplace_back(top, (kRings - 1) * kAround + b, (kRings - 1) * kAround + a);
  }
  model.faces.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (size_t f = 0; f < faces.size(); ++f)
    model.faces.row(static_cast<Eigen::Index>(f)) = faces[f].transpose();
  model.weights = spine_weights(model.template_vertices.col(1));

  model.parents = Eigen::Map<const Eigen::VectorXi>(kParents, body::kJoints);
  model.bind_pose = Points3::Zero(body::kJoints, 3);
  std::vector<Eigen::Triplet<double>> regressor;  // each joint at the centre of a ring
  for (int j = 0; j < body::kJoints; ++j) {
    const int ring =
        static_cast<int>(std::find(std::begin(kSpine), std::end(kSpine), j) - std::begin(kSpine)) %
        kRings;
    for (int a = 0; a < kAround; ++a) regressor.emplace_back(j, ring * kAround + a, 1.0 / kAround);
  }
  model.joint_regressor.resize(body::kJoints, count);
  model.joint_regressor.setFromTriplets(regressor.begin(), regressor.end());
  return model;
}

// The tube of radius 0.2 m round the column.
inline garment::Garment tube_garment(const Tube& tube, const garment::Design& design) {
  garment::Garment garment;
  garment.design = design;
  garment.topology = tube.topology;
  garment.t_pose = tube_positions(tube);
  garment.panels.resize(tube.at.rows(), 2);
  garment.panels.col(0) = 0.2 * tube.at.col(1);
  garment.panels.col(1) = tube.at.col(0);
  garment.weights = spine_weights(garment.t_pose.col(1));
  return garment;
}

// A pose of the spine, bending and twisting with time.
inline body::Pose spine_pose(double time) {
  body::Pose pose;
  pose.rotations.row(0) << 0.1 * std::sin(time), 0.5 * time, 0.05;
  for (int k = 1; k < 5; ++k)
    pose.rotations.row(kSpine[k]) << 0.15 * std::sin(time + k), 0.1, 0.12 * std::cos(2 * time);
  pose.translation << 0.2 * time, 0.9, -0.1 * time;
  return pose;
}

// The offsets that frame t of a clip was made with.
inline Points3 clip_offsets(const Tube& tube, int t) {
  return tube_wrinkles(tube, 0.004 + 0.002 * t, 5) + 0.01 * tube_wrinkles(tube, 1, 2);
}

inline garment::Clip tube_clip(const Tube& tube, const garment::Garment& garment,
                               const body::BodyModel& model, const std::string& motion,
                               int frames) {
  garment::Clip clip;
  clip.design = garment.design;
  clip.motion_name = motion;
  clip.shape.resize(2);
  clip.shape << 0.5, -1;
  const body::ShapedBody body = body::shape_body(model, clip.shape);
  const double start = static_cast<double>(motion.size());  // so that motions differ
  for (int t = 0; t < frames; ++t) {
    clip.poses.push_back(spine_pose(start + 0.1 * t));
    const Points3 unposed = garment.t_pose + clip_offsets(tube, t);
    clip.positions.push_back(body::skin_linear(
        unposed, garment.weights, body::joint_transforms(model, body, clip.poses.back())));
    garment::Certificate certificate;
    certificate.is_accepted = true;
    certificate.residual = 1e-4;
    certificate.min_gap_m = 0.001;
    clip.certificates.push_back(certificate);
  }
  return clip;
}

// A folder for one test's files, removed with it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "pleat-encode-XXXXXX").string();
    if (mkdtemp(name.data())) path_ = name;
  }
  ~TemporaryFolder() {
    if (!path_.empty()) std::filesystem::remove_all(path_);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

}  // namespace pleat::encode
