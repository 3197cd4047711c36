#pragma once

#include <string>

#include "body/motion.h"

namespace pleat::body {

// BVH (through assimp), retargeted to the model's 24 joints and leg length; frames and rate as
// recorded.
Motion read_bvh(const std::string& path, const BodyModel& model, double shoulder_abduction_deg = 0);

}  // namespace pleat::body
