#include "body/amass_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "body/rotation.h"
#include "core/error.h"
#include "core/npz_file.h"

namespace pleat::body {
namespace {

constexpr int kBodyJoints =
    22;  // shared by SMPL, SMPL+H and SMPL-X; what follows are hands, fingers and face
constexpr int kSmplhColumns = 156;

Mat<3> z_up_to_y_up() {
  Mat<3> rotation;
  rotation << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  return rotation;
}

// T x columns.
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
Rows read_rows(const NpzFile& file, const std::string& key, int64_t least_columns,
               int64_t frames = -1) {
  const NpyArray array = file.read(key);
  if (array.shape.size() != 2 || array.shape[1] < least_columns ||
      (frames >= 0 && array.shape[0] != frames)) {
    std::string shape;
    for (int64_t n : array.shape) shape += (shape.empty() ? "" : " x ") + std::to_string(n);
    throw InputError(file.path() + ": " + key + " is " + shape + "; expected " +
                     (frames >= 0 ? std::to_string(frames) : "frames") + " x " +
                     std::to_string(least_columns));
  }
  for (int64_t i = 0; i < array.size(); ++i) {
    if (!std::isfinite(array.values[i])) {
      throw InputError(file.path() + ": " + key + " is not finite in frame " +
                       std::to_string(i / array.shape[1]));
    }
  }
  return Eigen::Map<const Rows>(array.values.data(), array.shape[0], array.shape[1]);
}

// SMPL+H files say mocap_framerate, SMPL-X files mocap_frame_rate; 120.00004577 is meant as 120.
double read_frame_rate(const NpzFile& file) {
  for (const char* key : {"mocap_framerate", "mocap_frame_rate"}) {
    if (!file.has(key)) continue;
    const NpyArray array = file.read(key);
    if (array.size() != 1 || !(array.values[0] > 0 && array.values[0] < 10000)) {
      throw InputError(file.path() + ": " + key +
                       " is not a usable frame rate; expected one number above 0");
    }
    const double rate = array.values[0];
    return std::abs(rate - std::round(rate)) < 0.01 ? std::round(rate) : rate;
  }
  throw InputError(file.path() +
                   ": neither mocap_framerate nor mocap_frame_rate; expected an AMASS motion");
}

}  // namespace

Motion read_amass(const std::string& path, const Vec<3>& joint_0) {
  const NpzFile file(path);
  Rows poses;
  if (file.has("poses")) {
    poses = read_rows(file, "poses", 3 * kBodyJoints);
  } else if (file.has("root_orient") && file.has("pose_body")) {
    const Rows root = read_rows(file, "root_orient", 3);
    const Rows rest = read_rows(file, "pose_body", 3 * (kBodyJoints - 1), root.rows());
    poses.resize(root.rows(), 3 * kBodyJoints);
    poses << root.leftCols(3), rest.leftCols(3 * (kBodyJoints - 1));
  } else {
    throw InputError(path +
                     ": no poses, and no root_orient with pose_body; expected an AMASS motion "
                     "(shape.npz and *_stagei.npz "
                     "hold none)");
  }
  if (poses.rows() == 0) throw InputError(path + ": poses has no frames");
  const Rows translations = read_rows(file, "trans", 3, poses.rows());

  Motion motion{std::filesystem::path(path).stem().string(), read_frame_rate(file), {}};
  const Mat<3> turn = z_up_to_y_up();
  for (Eigen::Index frame = 0; frame < poses.rows(); ++frame) {
    Pose pose;
    for (int j = 0; j < kBodyJoints; ++j) pose.rotations.row(j) = poses.block<1, 3>(frame, 3 * j);
    pose.rotations.row(0) = axis_angle(turn * rotation_matrix(pose.rotations.row(0)));
    const Vec<3> translation = translations.row(frame).head<3>();
    pose.translation = turn * (translation + joint_0) - joint_0;
    motion.frames.push_back(pose);
  }
  return motion;
}

void write_amass(const std::string& path, const Motion& motion, const Vec<3>& joint_0) {
  const auto frames = static_cast<int64_t>(motion.frames.size());
  NpyArray poses{{frames, kSmplhColumns},
                 std::vector<double>(static_cast<size_t>(frames * kSmplhColumns), 0.0)};
  NpyArray translations{{frames, 3}, {}};
  const Mat<3> turn = z_up_to_y_up().transpose();
  for (int64_t k = 0; k < frames; ++k) {
    const Pose& pose = motion.frames[k];
    double* row = poses.values.data() + k * kSmplhColumns;
    for (int j = 0; j < kBodyJoints; ++j) {
      Vec<3> rotation = pose.rotations.row(j);
      if (j == 0) rotation = axis_angle(turn * rotation_matrix(rotation));
      std::copy(rotation.data(), rotation.data() + 3, row + 3 * j);
    }
    const Vec<3> translation = turn * (pose.translation + joint_0) - joint_0;
    translations.values.insert(translations.values.end(), translation.data(),
                               translation.data() + 3);
  }
  write_npz(path, {{"poses", "<f8", poses, ""},
                   {"trans", "<f8", translations, ""},
                   {"betas", "<f8", {{16}, std::vector<double>(16, 0.0)}, ""},
                   {"gender", "text", {}, "neutral"},
                   {"mocap_framerate", "<f8", {{}, {motion.frame_rate_hz}}, ""}});
}

}  // namespace pleat::body
