// Posed garment <-> offsets from its T-pose template, by the skinning that the paper's equation 1
// calls W.
#pragma once

#include <string>
#include <vector>

#include "body/skinning.h"
#include "garment/template.h"

namespace pleat::encode {

enum class Skinning { kLinear, kDualQuaternion };
Skinning parse_skinning(const std::string& name);  // "linear" or "dual_quaternion"
std::string skinning_name(Skinning skinning);

// posed: sewn vertices, m, world. transforms: body::joint_transforms of the same shape and pose.
// Returned: unposed - template, m, T-pose. What the shape does to the garment is part of the
// offset, as in equation 2. smallest_singular_value: of each vertex's blended linear part (1 rigid,
// 0 not invertible); 1 with dual quaternions.
Points3 unpose(const garment::Garment& garment, const Eigen::Ref<const Points3>& posed,
               const std::vector<body::Transform>& transforms, Skinning skinning,
               Eigen::VectorXd* smallest_singular_value = nullptr);

// Sewn vertices, m, world.
Points3 pose(const garment::Garment& garment, const Eigen::Ref<const Points3>& offsets,
             const std::vector<body::Transform>& transforms, Skinning skinning);

}  // namespace pleat::encode
