// How much several samples of one pose, shape and design differ: 0 where the model always says the
// same.
#pragma once

#include <vector>

#include "core/types.h"

namespace pleat::evaluate {

// Mean over the vertices of the root mean square distance from the samples' mean, mm. At least two
// samples, m.
double spread_mm(const std::vector<Points3>& samples);

}  // namespace pleat::evaluate
