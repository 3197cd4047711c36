// What a drape depends on, c = [beta, theta, p] (paper, section 4.1), and the numbers that the
// network sees of it.
#pragma once

#include <cstdint>

#include "core/types.h"

namespace pleat::learn {

struct Condition {
  Points3 pose;           // J x 3, axis-angle, rad, local to the parent; row 0 the root
  Eigen::VectorXd shape;  // beta
  Vec<3> design;          // p = (length, sleeve, cleavage)
};

int64_t feature_count(int64_t joints, int64_t shape_count);

// Root: the direction of gravity seen from the root, 3 numbers. A static drape hangs the same way
// wherever the
//   wearer stands and faces, and offsets are stored in the T-pose, so translation and heading tell
//   nothing.
// Other joints: the first two columns of the rotation matrix less the identity's, 6 numbers each.
// Unlike
//   axis-angle they are continuous and unique (Zhou et al. 2019, "On the Continuity of Rotation
//   Representations in Neural Networks"), so that like poses are like inputs.
// Then beta and p as they are.
Eigen::VectorXf condition_features(const Condition& condition);

}  // namespace pleat::learn
