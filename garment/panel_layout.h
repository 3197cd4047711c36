// Where the four panels lie in UV: one affine map a panel, from the reference panel to [0,1]^2, v
// up. No design and no tessellation changes it.
#pragma once

#include "core/types.h"
#include "garment/pattern.h"

namespace pleat::garment {

Points2 reference_to_uv(Panel panel, const Eigen::Ref<const Points2>& reference);  // # x 2, m -> UV
Points2 uv_to_reference(Panel panel, const Eigen::Ref<const Points2>& uv);

}  // namespace pleat::garment
