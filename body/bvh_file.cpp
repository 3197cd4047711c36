#include "body/bvh_file.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <filesystem>
#include <map>

#include "body/rotation.h"
#include "core/error.h"

namespace pleat::body {
namespace {

// One BVH joint: its place in the tree and its motion.
struct BvhJoint {
  std::string name;
  int parent = -1;
  Vec<3> offset = Vec<3>::Zero();             // to the parent, file units
  std::vector<Eigen::Quaterniond> rotations;  // one a frame, or a single one
  std::vector<Vec<3>> positions;              // the same
};

struct Bvh {
  std::vector<BvhJoint> joints;  // parents first
  int frame_count = 0;
  double frame_rate_hz = 0;

  int find(const std::string& name) const {
    for (size_t j = 0; j < joints.size(); ++j) {
      if (joints[j].name == name) return static_cast<int>(j);
    }
    return -1;
  }
};

// Global rotations and positions of all joints.
struct BvhPose {
  std::vector<Mat<3>> rotations;
  std::vector<Vec<3>> positions;
};

void collect_joints(const aiNode* node, int parent, Bvh& bvh) {
  const int index = static_cast<int>(bvh.joints.size());
  BvhJoint joint;
  joint.name = node->mName.C_Str();
  joint.parent = parent;
  joint.offset = {node->mTransformation.a4, node->mTransformation.b4, node->mTransformation.c4};
  bvh.joints.push_back(joint);
  for (unsigned c = 0; c < node->mNumChildren; ++c) collect_joints(node->mChildren[c], index, bvh);
}

Bvh read_file(const std::string& path) {
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  if (!std::filesystem::is_regular_file(path)) throw InputError(path + ": no such file");
  const aiScene* scene = importer.ReadFile(path, 0);
  if (!scene || !scene->mRootNode)
    throw InputError(path + ": not a BVH file: " + importer.GetErrorString());
  if (scene->mNumAnimations != 1) throw InputError(path + ": has no motion");
  const aiAnimation& animation = *scene->mAnimations[0];
  Bvh bvh;
  collect_joints(scene->mRootNode, -1, bvh);
  bvh.frame_rate_hz = animation.mTicksPerSecond;
  if (!(bvh.frame_rate_hz > 0.1 && bvh.frame_rate_hz < 10000)) {
    throw InputError(path + ": frame time is not usable; expected 0.0001 .. 10 s");
  }
  const double whole = std::round(bvh.frame_rate_hz);  // files round 1/120 to 0.0083333
  if (std::abs(bvh.frame_rate_hz - whole) < 1e-3 * whole) bvh.frame_rate_hz = whole;

  for (unsigned c = 0; c < animation.mNumChannels; ++c) {
    const aiNodeAnim& channel = *animation.mChannels[c];
    const int j = bvh.find(channel.mNodeName.C_Str());
    if (j < 0) continue;
    for (unsigned k = 0; k < channel.mNumRotationKeys; ++k) {
      const aiQuaternion& q = channel.mRotationKeys[k].mValue;
      const Eigen::Quaterniond rotation(q.w, q.x, q.y, q.z);
      if (!rotation.coeffs().allFinite()) {
        throw InputError(path + ": rotation of " + bvh.joints[j].name + " is not finite in frame " +
                         std::to_string(k));
      }
      bvh.joints[j].rotations.push_back(rotation.normalized());
    }
    for (unsigned k = 0; k < channel.mNumPositionKeys; ++k) {
      const aiVector3D& p = channel.mPositionKeys[k].mValue;
      const Vec<3> position(p.x, p.y, p.z);
      if (!position.allFinite()) {
        throw InputError(path + ": position of " + bvh.joints[j].name + " is not finite in frame " +
                         std::to_string(k));
      }
      bvh.joints[j].positions.push_back(position);
    }
    bvh.frame_count = std::max<int>(bvh.frame_count, static_cast<int>(channel.mNumRotationKeys));
  }
  if (bvh.frame_count < 1) throw InputError(path + ": has no frames");
  return bvh;
}

// frame -1: the zero pose, all rotations zero and all joints at their offsets.
BvhPose pose_at(const Bvh& bvh, int frame) {
  BvhPose pose;
  for (const BvhJoint& joint : bvh.joints) {
    Mat<3> rotation = Mat<3>::Identity();
    Vec<3> position = joint.offset;
    if (frame >= 0 && !joint.rotations.empty()) {
      rotation =
          joint.rotations[std::min<size_t>(frame, joint.rotations.size() - 1)].toRotationMatrix();
    }
    if (frame >= 0 && !joint.positions.empty()) {
      position = joint.positions[std::min<size_t>(frame, joint.positions.size() - 1)];
    }
    if (joint.parent >= 0) {
      position = pose.positions[joint.parent] + pose.rotations[joint.parent] * position;
      rotation = pose.rotations[joint.parent] * rotation;
    }
    pose.positions.push_back(position);
    pose.rotations.push_back(rotation);
  }
  return pose;
}

// Which BVH joint turns each of the model's joints.
struct JointMap {
  std::array<int, kJoints> joint;     // -1: stays as its parent
  std::array<int, 3> spine;           // joints of spine1..3: BVH joint to start from,
  std::array<int, 3> spine_next;      // and where it is blended with the next,
  std::array<double, 3> spine_blend;  // how far
};

int find_any(const Bvh& bvh, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const int j = bvh.find(name);
    if (j >= 0) return j;
  }
  return -1;
}

JointMap map_joints(const Bvh& bvh, const std::string& path) {
  JointMap map;
  map.joint.fill(-1);
  const auto need = [&](int joint, const std::vector<std::string>& names) {
    const int j = find_any(bvh, names);
    if (j < 0) {
      throw InputError(path + ": no joint for " + kJointNames[joint] + "; expected one of " +
                       names[0] + (names.size() > 1 ? ", " + names[1] : ""));
    }
    map.joint[joint] = j;
  };
  need(0, {"Hips", "hip"});
  for (int side = 0; side < 2; ++side) {
    const std::string prefix = side == 0 ? "Left" : "Right";
    // LeftShoulder is the collar where LeftArm exists, the upper arm where LeftCollar exists.
    const bool has_arm = bvh.find(prefix + "Arm") >= 0;
    need(1 + side, {prefix + "UpLeg", prefix + "Hip"});
    need(4 + side, {prefix + "Leg", prefix + "Knee"});
    need(7 + side, {prefix + "Foot", prefix + "Ankle"});
    map.joint[10 + side] = find_any(bvh, {prefix + "ToeBase", prefix + "Toe", prefix + "Toes"});
    map.joint[13 + side] = bvh.find(prefix + (has_arm ? "Shoulder" : "Collar"));
    need(16 + side, {prefix + (has_arm ? "Arm" : "Shoulder")});
    need(18 + side, {prefix + (has_arm ? "ForeArm" : "Elbow")});
    need(20 + side, {prefix + (has_arm ? "Hand" : "Wrist")});
  }
  need(12, {"Neck"});
  need(15, {"Head"});

  // The chain from the hips up to what carries the collars, spread over the model's three spine
  // joints.
  std::vector<int> chain;
  const int top = map.joint[13] >= 0 ? map.joint[13] : map.joint[16];
  for (int j = bvh.joints[top].parent; j >= 0 && j != map.joint[0]; j = bvh.joints[j].parent) {
    chain.insert(chain.begin(), j);
  }
  chain.insert(chain.begin(), map.joint[0]);
  for (int k = 0; k < 3; ++k) {
    const double at = (k + 1) * (static_cast<double>(chain.size()) - 1) / 3;
    const auto below = std::min(static_cast<size_t>(at + 1e-9), chain.size() - 1);
    map.spine[k] = chain[below];
    map.spine_next[k] = chain[std::min(below + 1, chain.size() - 1)];
    map.spine_blend[k] = at - static_cast<double>(below);
  }
  return map;
}

// Rotation of the file's axes that brings a standing figure to y up, facing +z, left arm towards
// +x.
Mat<3> upright(const BvhPose& pose, const JointMap& map) {
  const Vec<3> hips = (pose.positions[map.joint[1]] + pose.positions[map.joint[2]]) / 2;
  const Vec<3> up = (pose.positions[map.joint[12]] - hips).normalized();
  const Vec<3> left = pose.positions[map.joint[1]] - pose.positions[map.joint[2]];
  Mat<3> axes;
  axes.row(2) = left.cross(up).normalized();
  axes.row(1) = up;
  axes.row(0) = up.cross(axes.row(2).transpose());
  return axes;
}

// A pose to compare bones in: trunk and head up, legs down.
bool is_standing(const BvhPose& pose, const JointMap& map) {
  const Mat<3> axes = upright(pose, map);
  if (!axes.allFinite()) return false;
  for (int side = 0; side < 2; ++side) {
    const Vec<3> leg =
        axes * (pose.positions[map.joint[7 + side]] - pose.positions[map.joint[1 + side]]);
    if (!(-leg.y() > 0.7 * leg.norm())) return false;
  }
  const Vec<3> head = axes * (pose.positions[map.joint[15]] - pose.positions[map.joint[12]]);
  return head.norm() < 1e-9 || head.y() > 0.5 * head.norm();
}

// Snaps to the nearest rotation among the axes, so that a small lean of the figure is not taken for
// a lean of the file.
Mat<3> nearest_axes(const Mat<3>& rotation) {
  Mat<3> best = Mat<3>::Identity();
  double least = std::numeric_limits<double>::infinity();
  for (int x = 0; x < 6; ++x) {
    for (int y = 0; y < 6; ++y) {
      if (x / 2 == y / 2) continue;
      Mat<3> candidate = Mat<3>::Zero();
      candidate(0, x / 2) = x % 2 ? -1 : 1;
      candidate(1, y / 2) = y % 2 ? -1 : 1;
      candidate.row(2) = candidate.row(0).transpose().cross(candidate.row(1).transpose());
      const double distance = (candidate - rotation).norm();
      if (distance < least) least = distance, best = candidate;
    }
  }
  return best;
}

// Collar bones sink as the arms come down from the T-pose (scapulohumeral rhythm); the skeletons of
// BVH files leave that to the shoulder alone, and the wearer would shrug.
constexpr double kCollarDrop = 8 * M_PI / 180, kCollarDropFrom = 45 * M_PI / 180;

// Far end of the model joint's bone, for those that are aligned with the file's.
constexpr std::array<int, kJoints> kBoneEnd = {-1, 4,  5,  -1, 7,  8,  -1, 10, 11, -1, -1, -1,
                                               -1, -1, -1, -1, 18, 19, 20, 21, -1, -1, -1, -1};

}  // namespace

Motion read_bvh(const std::string& path, const BodyModel& model, double shoulder_abduction_deg) {
  const Bvh bvh = read_file(path);
  const JointMap map = map_joints(bvh, path);
  const Points3 rest = shape_body(model, Eigen::VectorXd()).joints;

  // The pose in which both skeletons are compared: the file's zero pose, or its first frame where
  // that is a T-pose.
  BvhPose reference = pose_at(bvh, -1);
  if (!is_standing(reference, map)) {
    reference = pose_at(bvh, 0);
    if (!is_standing(reference, map)) {
      throw InputError(path +
                       ": neither the zero pose nor the first frame stands upright; expected a "
                       "T-pose in one of them");
    }
  }
  const Mat<3> axes = nearest_axes(upright(reference, map));
  double model_leg = 0, file_leg = 0;
  for (int side = 0; side < 2; ++side) {
    for (int j : {1, 4}) {
      const int a = j + side, b = kBoneEnd[a];
      model_leg += (rest.row(b) - rest.row(a)).norm();
      file_leg += (reference.positions[map.joint[b]] - reference.positions[map.joint[a]]).norm();
    }
  }
  if (!(file_leg > 0)) throw InputError(path + ": the legs have no length");
  const double scale = model_leg / file_leg;

  // Constant turn from the model's rest bone to the file's, in the model's axes.
  std::vector<Mat<3>> to_file(kJoints, Mat<3>::Identity());
  for (int j = 0; j < kJoints; ++j) {
    const int end = kBoneEnd[j];
    if (end >= 0 && map.joint[end] >= 0) {
      const Vec<3> bone =
          axes * (reference.positions[map.joint[end]] - reference.positions[map.joint[j]]);
      if (bone.norm() > 1e-9) to_file[j] = rotation_between(rest.row(end) - rest.row(j), bone);
    } else if (j == 10 || j == 11 || j >= 20) {
      to_file[j] = to_file[kParents[j]];
    }
  }

  Motion motion{std::filesystem::path(path).stem().string(), bvh.frame_rate_hz, {}};
  const Vec<3> rest_hips = (rest.row(1) + rest.row(2)).transpose() / 2 - rest.row(0).transpose();
  const double abduction = shoulder_abduction_deg * M_PI / 180;
  for (int frame = 0; frame < bvh.frame_count; ++frame) {
    const BvhPose pose = pose_at(bvh, frame);
    const auto turned = [&](int bvh_joint) -> Mat<3> {  // since the reference, in the model's axes
      return axes * pose.rotations[bvh_joint] * reference.rotations[bvh_joint].transpose() *
             axes.transpose();
    };
    std::vector<Mat<3>> global(kJoints);
    Pose result;
    for (int j = 0; j < kJoints; ++j) {
      const int spine = j == 3 ? 0 : j == 6 ? 1 : j == 9 ? 2 : -1;
      if (spine >= 0) {
        const Vec<3> a = axis_angle(turned(map.spine[spine])),
                     b = axis_angle(turned(map.spine_next[spine]));
        global[j] = rotation_matrix(slerp(a, b, map.spine_blend[spine]));
      } else if (map.joint[j] >= 0) {
        global[j] = turned(map.joint[j]) * to_file[j];
      } else {
        global[j] = global[kParents[j]];
      }
    }
    for (int side = 0; side < 2; ++side) {
      const int collar = 13 + side, arm = 16 + side;
      const Vec<3> upper_arm =
          global[9].transpose() * global[arm] * (rest.row(18 + side) - rest.row(arm)).transpose();
      const double below =
          -std::asin(std::clamp(upper_arm.normalized().y(), -1.0, 1.0));  // horizontal, rad
      const double drop = kCollarDrop * std::clamp(below / kCollarDropFrom, 0.0, 1.0);
      global[collar] = global[collar] * rotation_matrix({0, 0, side == 0 ? -drop : drop});
    }
    for (int j = 0; j < kJoints; ++j) {
      const Mat<3> local = j == 0 ? global[0] : Mat<3>(global[kParents[j]].transpose() * global[j]);
      result.rotations.row(j) = axis_angle(local);
    }
    for (int side = 0; side < 2 && abduction != 0; ++side) {
      const Vec<3> outward(0, 0, side == 0 ? abduction : -abduction);
      const Mat<3> local =
          rotation_matrix(result.rotations.row(16 + side)) * rotation_matrix(outward);
      result.rotations.row(16 + side) = axis_angle(local);
    }
    const Vec<3> hips = axes * (pose.positions[map.joint[1]] + pose.positions[map.joint[2]]) / 2;
    result.translation = scale * hips - rest.row(0).transpose() - global[0] * rest_hips;
    motion.frames.push_back(result);
  }
  return motion;
}

}  // namespace pleat::body
