// A motion: 24 joint rotations and the root's translation over time, y up, metres, facing +z at
// zero rotation.
#pragma once

#include <string>
#include <vector>

#include "body/body_model.h"
#include "core/types.h"

namespace pleat::body {

struct Pose {
  Points3 rotations =
      Points3::Zero(kJoints, 3);        // kJoints x 3, axis-angle, rad, local to the parent
  Vec<3> translation = Vec<3>::Zero();  // m, added after the root has turned about its joint (SMPL)
};

struct Motion {
  std::string name;
  double frame_rate_hz = 30;
  std::vector<Pose> frames;
};

struct MotionConfig {         // section `motion`
  double frame_rate_hz = 30;  // what the motion is resampled to
  double start_s = 0;         // cut
  double duration_s = 0;      // 0: to the end
  double max_joint_step_deg =
      75;  // per 1/30 s, wrists and feet aside: above it a frame is a glitch
  double shoulder_abduction_deg = 8;  // of both upper arms (BVH only: its arms come out too close)
  bool ground = true;  // shift so that the lowest foot vertex of the sequence stands at y = 0
};
void validate(const MotionConfig& config);

// .npz: AMASS; .bvh: retargeted to `model`. Then leading T-poses are dropped, the piece start_s,
// duration_s is cut out, glitches are repaired where a few frames are at fault or else refused, and
// the rest is resampled and grounded. InputError names file, array or joint, and frame.
Motion load_motion(const std::string& path, const BodyModel& model, const MotionConfig& config);

// What `pleat motion info` tells of a file.
struct MotionInfo {
  int frames = 0;             // as recorded
  double frame_rate_hz = 0;   // as recorded
  double seconds = 0;         // from the first frame to the last
  int t_poses_dropped = 0;    // leading frames
  int glitches_repaired = 0;  // runs of frames
  std::string problem;  // why load_motion would refuse it; empty: it does not, and the rest holds
                        // for what it returns
  double max_joint_step_deg = 0;  // per 1/30 s, wrists and feet aside, after repair
  std::string max_step_joint;
  double lowest_foot_m = 0;  // y, before grounding
  double path_length_m = 0;  // of the pelvis over the ground
};
MotionInfo motion_info(const std::string& path, const BodyModel& model, const MotionConfig& config);

Motion resample(const Motion& motion, double frame_rate_hz);  // slerp, linear translation
Pose blend(const Pose& a, const Pose& b, double t);  // t = 0: a; slerp per joint, shortest way

// Height (y, m) of the lowest vertex of the feet over all frames.
double lowest_foot_height(const Motion& motion, const BodyModel& model, const ShapedBody& body);

// Number of leading frames that are a T-pose from which the next frame jumps away: calibration, not
// motion.
int leading_t_poses(const Motion& motion, double max_joint_step_deg);

// Frames in which a joint jumps away and, within 0.2 s, back, by spherical interpolation across
// them. Returns the number of such runs. Throws InputError naming `source`, joint and frame (+
// first_frame) where a joint jumps and stays.
int repair_glitches(Motion& motion, double max_joint_step_deg, const std::string& source,
                    int first_frame = 0);

}  // namespace pleat::body
