// How far the motion from one frame to the next is from the simulated one (paper, figure 5 right):
// what flickers, shows here.
#pragma once

#include "core/types.h"

namespace pleat::evaluate {

// Mean over the vertices of |(x_t - x_t-1) - (truth_t - truth_t-1)| * rate, mm/s. All points m,
// world.
double velocity_error_mm_per_s(const Eigen::Ref<const Points3>& previous,
                               const Eigen::Ref<const Points3>& current,
                               const Eigen::Ref<const Points3>& previous_truth,
                               const Eigen::Ref<const Points3>& truth, double frame_rate_hz);

}  // namespace pleat::evaluate
