#pragma once

#include <string>

#include "body/body_model.h"

namespace pleat::body {

// SMPL, SMPL+H and SMPL-X .npz files, and Pleat's own (SMPL's keys and `bind_pose`). A pickle
// (.pkl) is refused with the sentence that tells how to convert it. Open meshes, NaN, wrong shapes:
// InputError naming file and array.
BodyModel read_body(const std::string& path);
void write_body(const std::string& path, const BodyModel& model);

}  // namespace pleat::body
