#pragma once

#include <vector>

#include "core/types.h"

namespace pleat::body {

struct CavityConfig {
  int views = 80;        // directions on a sphere
  int pixels = 1024;     // of one view's side, over the candidates' extent
  int least_faces = 24;  // smaller hidden patches (folds behind an ear) stay
};

// Surface without the pockets that no view from outside sees, their mouths closed by flat
// triangles. Only faces with is_candidate may go. `blockers`, more faces over the same vertices
// (eyeballs), hide what lies behind them.
Faces close_cavities(const Eigen::Ref<const Points3>& vertices, const Faces& faces,
                     const std::vector<char>& is_candidate, const Faces& blockers,
                     const CavityConfig& config = {});

}  // namespace pleat::body
