#pragma once

#include <string>

#include "body/motion.h"

namespace pleat::body {

// AMASS .npz, SMPL+H and SMPL-X generations, z up, to y up; frames and rate as recorded. joint_0:
// the model's pelvis joint, which the recorded translation refers to. InputError names file and
// array (missing, NaN, wrong shape).
Motion read_amass(const std::string& path, const Vec<3>& joint_0);
// AMASS layout of the SMPL+H generation: poses (T,156), trans, betas, gender, mocap_framerate, z
// up.
void write_amass(const std::string& path, const Motion& motion, const Vec<3>& joint_0);

}  // namespace pleat::body
