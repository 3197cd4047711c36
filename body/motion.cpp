#include "body/motion.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "body/amass_file.h"
#include "body/bvh_file.h"
#include "body/rotation.h"
#include "body/skinning.h"
#include "core/error.h"

namespace pleat::body {
namespace {

constexpr double kDegree = M_PI / 180;
constexpr double kStepRateHz = 30;      // steps are stated per 1/30 s
constexpr double kLongestGlitch = 0.2;  // s
constexpr double kTPoseArm = 12 * kDegree, kTPoseTrunk = 5 * kDegree;

// Wrists, hands, ankles and toes flip in raw mocap without harm to a garment.
bool is_checked(int joint) {
  constexpr std::array<int, 8> kFree = {7, 8, 10, 11, 20, 21, 22, 23};
  return std::find(kFree.begin(), kFree.end(), joint) == kFree.end();
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

double step(const Motion& motion, int from, int to, int joint) {
  return angle_between(motion.frames[from].rotations.row(joint),
                       motion.frames[to].rotations.row(joint));
}

// Largest step between neighbouring frames that still is motion, rad.
double step_limit(const Motion& motion, double max_joint_step_deg) {
  return std::min(max_joint_step_deg * kStepRateHz / motion.frame_rate_hz, 170.0) * kDegree;
}

bool is_t_pose(const Pose& pose) {
  for (int j : {3, 6, 9, 12, 15}) {
    if (pose.rotations.row(j).norm() > kTPoseTrunk) return false;
  }
  for (int j : {13, 14, 16, 17, 18, 19}) {
    if (pose.rotations.row(j).norm() > kTPoseArm) return false;
  }
  return true;
}

Pose at_time(const Motion& motion, double frame) {
  const int last = static_cast<int>(motion.frames.size()) - 1;
  const int before = std::clamp(static_cast<int>(std::floor(frame)), 0, last);
  const double t = frame - before;
  if (before == last || t < 1e-6) return motion.frames[before];
  if (t > 1 - 1e-6) return motion.frames[before + 1];
  return blend(motion.frames[before], motion.frames[before + 1], t);
}

// From start to end, both s, at a new rate; the last frame falls on end or less than a step before
// it.
Motion resample(const Motion& motion, double frame_rate_hz, double start, double end) {
  Motion result{motion.name, frame_rate_hz, {}};
  const int count = static_cast<int>(std::floor((end - start) * frame_rate_hz + 1e-3)) + 1;
  for (int k = 0; k < count; ++k) {
    const double frame = (start + k / frame_rate_hz) * motion.frame_rate_hz;
    const double nearest = std::round(frame);
    result.frames.push_back(at_time(motion, std::abs(frame - nearest) < 1e-6 ? nearest : frame));
  }
  return result;
}

Motion read_motion(const std::string& path, const BodyModel& model, const MotionConfig& config) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  if (extension == ".npz")
    return read_amass(path, shape_body(model, Eigen::VectorXd()).joints.row(0));
  if (extension == ".bvh") return read_bvh(path, model, config.shoulder_abduction_deg);
  throw InputError(path + ": unknown kind of motion; expected AMASS (.npz) or .bvh");
}

struct Loaded {
  Motion motion;
  double lowest_foot = 0;
  int glitches = 0;
};

// From the motion as recorded, `dropped` leading frames taken off, to the motion that is used.
Loaded prepare(Motion motion, int dropped, const std::string& path, const BodyModel& model,
               const MotionConfig& config) {
  motion.frames.erase(motion.frames.begin(), motion.frames.begin() + dropped);
  const double rate = motion.frame_rate_hz;
  const double length = (static_cast<double>(motion.frames.size()) - 1) / rate;
  if (config.start_s > length) {
    throw InputError(path + ": motion.start_s = " + number(config.start_s) + "; the motion is " +
                     number(length) + " s long");
  }
  const double end =
      config.duration_s > 0 ? std::min(length, config.start_s + config.duration_s) : length;

  // Only what is used must be free of glitches.
  const int first = static_cast<int>(std::floor(config.start_s * rate + 1e-6));
  const int last = std::min(static_cast<int>(std::ceil(end * rate - 1e-6)),
                            static_cast<int>(motion.frames.size()) - 1);
  motion.frames.erase(motion.frames.begin() + last + 1, motion.frames.end());
  motion.frames.erase(motion.frames.begin(), motion.frames.begin() + first);
  Loaded loaded;
  loaded.glitches = repair_glitches(motion, config.max_joint_step_deg, path, first + dropped);
  const double offset = first / rate;
  loaded.motion = resample(motion, config.frame_rate_hz, config.start_s - offset, end - offset);
  loaded.lowest_foot =
      lowest_foot_height(loaded.motion, model, shape_body(model, Eigen::VectorXd()));
  if (config.ground) {
    for (Pose& pose : loaded.motion.frames) pose.translation.y() -= loaded.lowest_foot;
  }
  return loaded;
}

}  // namespace

void validate(const MotionConfig& config) {
  const auto check = [](bool holds, const std::string& key, double value,
                        const std::string& expected) {
    if (!holds)
      throw InputError("motion." + key + " = " + number(value) + "; expected " + expected);
  };
  check(config.frame_rate_hz > 0 && config.frame_rate_hz <= 1000, "frame_rate_hz",
        config.frame_rate_hz, "above 0 and at most 1000");
  check(config.start_s >= 0 && std::isfinite(config.start_s), "start_s", config.start_s, ">= 0");
  check(config.duration_s >= 0 && std::isfinite(config.duration_s), "duration_s", config.duration_s,
        ">= 0");
  check(config.max_joint_step_deg > 0 && config.max_joint_step_deg <= 180, "max_joint_step_deg",
        config.max_joint_step_deg, "above 0 and at most 180");
  check(std::abs(config.shoulder_abduction_deg) <= 90, "shoulder_abduction_deg",
        config.shoulder_abduction_deg, "-90 .. 90");
}

Motion load_motion(const std::string& path, const BodyModel& model, const MotionConfig& config) {
  validate(config);
  Motion motion = read_motion(path, model, config);
  const int dropped = leading_t_poses(motion, config.max_joint_step_deg);
  return prepare(std::move(motion), dropped, path, model, config).motion;
}

MotionInfo motion_info(const std::string& path, const BodyModel& model,
                       const MotionConfig& config) {
  validate(config);
  const Motion recorded = read_motion(path, model, config);
  MotionInfo info;
  info.frames = static_cast<int>(recorded.frames.size());
  info.frame_rate_hz = recorded.frame_rate_hz;
  info.seconds = (info.frames - 1) / recorded.frame_rate_hz;
  info.t_poses_dropped = leading_t_poses(recorded, config.max_joint_step_deg);
  try {
    const Loaded loaded = prepare(recorded, info.t_poses_dropped, path, model, config);
    info.glitches_repaired = loaded.glitches;
    info.lowest_foot_m = loaded.lowest_foot;
    const Motion& motion = loaded.motion;
    for (size_t k = 1; k < motion.frames.size(); ++k) {
      for (int j = 0; j < kJoints; ++j) {
        const double angle = step(motion, static_cast<int>(k) - 1, static_cast<int>(k), j) /
                             kDegree * motion.frame_rate_hz / kStepRateHz;
        if (is_checked(j) && angle > info.max_joint_step_deg) {
          info.max_joint_step_deg = angle;
          info.max_step_joint = kJointNames[j];
        }
      }
      const Vec<3> moved = motion.frames[k].translation - motion.frames[k - 1].translation;
      info.path_length_m += std::hypot(moved.x(), moved.z());
    }
  } catch (const InputError& error) {
    info.problem = error.what();
  }
  return info;
}

Motion resample(const Motion& motion, double frame_rate_hz) {
  if (motion.frames.empty()) return {motion.name, frame_rate_hz, {}};
  return resample(motion, frame_rate_hz, 0,
                  (static_cast<double>(motion.frames.size()) - 1) / motion.frame_rate_hz);
}

Pose blend(const Pose& a, const Pose& b, double t) {
  Pose pose;
  for (int j = 0; j < kJoints; ++j)
    pose.rotations.row(j) = slerp(a.rotations.row(j), b.rotations.row(j), t);
  pose.translation = (1 - t) * a.translation + t * b.translation;
  return pose;
}

double lowest_foot_height(const Motion& motion, const BodyModel& model, const ShapedBody& body) {
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<int> feet;
  for (int v = 0; v < model.weights.rows(); ++v) {
    double on_foot = 0;
    for (SkinWeights::InnerIterator it(model.weights, v); it; ++it) {
      if (it.col() == 7 || it.col() == 8 || it.col() == 10 || it.col() == 11) on_foot += it.value();
    }
    if (on_foot < 0.5) continue;
    for (SkinWeights::InnerIterator it(model.weights, v); it; ++it) {
      entries.emplace_back(static_cast<int>(feet.size()), it.col(), it.value());
    }
    feet.push_back(v);
  }
  if (feet.empty() || motion.frames.empty()) return 0;
  SkinWeights weights(static_cast<Eigen::Index>(feet.size()), model.weights.cols());
  weights.setFromTriplets(entries.begin(), entries.end());
  Points3 points(weights.rows(), 3);
  for (size_t k = 0; k < feet.size(); ++k)
    points.row(static_cast<Eigen::Index>(k)) = body.vertices.row(feet[k]);
  double lowest = std::numeric_limits<double>::infinity();
  for (const Pose& pose :
       motion.frames) {  // pose blend shapes, below a millimetre at the soles, are left out
    lowest = std::min(
        lowest, skin_linear(points, weights, bind_to_pose(model, body, pose)).col(1).minCoeff());
  }
  return lowest;
}

int leading_t_poses(const Motion& motion, double max_joint_step_deg) {
  int count = 0;
  while (count < static_cast<int>(motion.frames.size()) && is_t_pose(motion.frames[count])) ++count;
  if (count == static_cast<int>(motion.frames.size())) return 0;
  for (int j = 0; j < kJoints && count > 0; ++j) {
    if (is_checked(j) && step(motion, count - 1, count, j) > step_limit(motion, max_joint_step_deg))
      return count;
  }
  return 0;
}

int repair_glitches(Motion& motion, double max_joint_step_deg, const std::string& source,
                    int first_frame) {
  const double limit = step_limit(motion, max_joint_step_deg);
  const int count = static_cast<int>(motion.frames.size());
  const int longest = std::max(1, static_cast<int>(kLongestGlitch * motion.frame_rate_hz));
  int repaired = 0;
  for (int j = 0; j < kJoints; ++j) {
    if (!is_checked(j)) continue;
    for (int bad = 1; bad < count; ++bad) {
      if (step(motion, bad - 1, bad, j) <= limit) continue;
      int good = -1;  // first frame after the jump that fits the one before it
      for (int k = bad + 1; k < count && k <= bad + longest && good < 0; ++k) {
        const double across = step(motion, bad - 1, k, j);
        if (across <= std::min(limit * (k - bad + 1), max_joint_step_deg * kDegree)) good = k;
      }
      if (good < 0) {
        throw InputError(
            source + ": joint " + kJointNames[j] + " jumps by " +
            std::to_string(static_cast<int>(std::round(step(motion, bad - 1, bad, j) / kDegree))) +
            " degrees at frame " + std::to_string(first_frame + bad) +
            " and does not come back; cut it out (motion.start_s, motion.duration_s) or raise "
            "motion.max_joint_step_deg");
      }
      const Vec<3> before = motion.frames[bad - 1].rotations.row(j),
                   after = motion.frames[good].rotations.row(j);
      for (int k = bad; k < good; ++k) {
        const double t = static_cast<double>(k - bad + 1) / (good - bad + 1);
        motion.frames[k].rotations.row(j) = slerp(before, after, t);
      }
      ++repaired;
      bad = good;  // steps up to here are within the limit now
    }
  }
  return repaired;
}

}  // namespace pleat::body
