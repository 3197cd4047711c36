#pragma once

#include "body/body_model.h"
#include "core/types.h"

namespace pleat::garment {

// Skin weights of the garment: those of the skin around it in the T-pose, averaged through space
// and then smoothed along the cloth, both more so the farther the cloth hangs from the body, so
// that a skirt does not tear between the legs.
SkinWeights garment_weights(const Eigen::Ref<const Points3>& t_pose, const Faces& faces,
                            const body::BodyModel& model, const body::ShapedBody& body);

}  // namespace pleat::garment
