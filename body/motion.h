// A motion: 24 joint rotations and the root's translation over time, y up, metres, facing +z at zero rotation.
#pragma once

#include <string>
#include <vector>

#include "body/body_model.h"
#include "core/types.h"

namespace pleat::body {

struct Pose {
  Points3 rotations = Points3::Zero(kJoints, 3);  // kJoints x 3, axis-angle, rad, local to the parent
  Vec<3> translation = Vec<3>::Zero();            // m, added after the root has turned about its joint (SMPL)
};

struct Motion {
  std::string name;
  double frame_rate_hz = 30;
  std::vector<Pose> frames;
};

struct MotionConfig {            // section `motion`
  double frame_rate_hz = 30;     // what the motion is resampled to
  double start_s = 0;            // cut
  double duration_s = 0;         // 0: to the end
  double max_joint_step_deg = 75;  // per 1/30 s, wrists and feet aside: above it a frame is a glitch
  double shoulder_abduction_deg = 0;  // added to both shoulders (BVH only, where arms come out too close)
  bool ground = true;            // shift so that the lowest foot vertex of the sequence stands at y = 0
};
void validate(const MotionConfig& config);

// .npz: AMASS; .bvh: retargeted to `model`. Then cleaned: leading T-poses dropped, glitches repaired where a
// few frames are at fault or else refused, resampled, cut, grounded. InputError names file, array and frame.
Motion load_motion(const std::string& path, const BodyModel& model, const MotionConfig& config);

Motion resample(const Motion& motion, double frame_rate_hz);  // slerp, linear translation
Pose blend(const Pose& a, const Pose& b, double t);           // t = 0: a; slerp per joint, shortest way

}  // namespace pleat::body
