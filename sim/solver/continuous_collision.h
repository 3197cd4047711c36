// How far two features may run along their motions before they meet: additive continuous collision
// detection, Li et al. 2021, "Codimensional Incremental Potential Contact", section 5. Conservative:
// each advance is at most the time in which the features could close the distance that is left.
#pragma once

#include "sim/solver/pair_distance.h"

namespace pleat::sim {

// The largest t in [0, 1] found such that on x + s * motion, 0 <= s <= t, the distance never falls
// below `keep` times that at the start. 0 < keep < 1.
double free_motion(PairKind kind, const PairPoints& x, const PairPoints& motion, double keep);

}  // namespace pleat::sim
