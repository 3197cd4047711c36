// Whether a garment could be one: outside of the body, and no more stretched than cloth is.
#pragma once

#include "core/mesh_quality.h"
#include "core/proximity.h"
#include "garment/template.h"

namespace pleat::evaluate {

struct Plausibility {
  double inside_share = 0;   // of the vertices, 0 .. 1
  double mean_depth_mm = 0;  // of the vertices inside
  double max_depth_mm = 0;
  int body_intersections = 0;  // cloth faces that cross the body
  Strain strain;               // of the cloth against its flat panels
};

// vertices: sewn, m, world. body: closed, in the same pose. Depths are exact up to
// search_distance_m.
Plausibility plausibility(const garment::Garment& garment,
                          const Eigen::Ref<const Points3>& vertices, const SurfaceTree& body,
                          double search_distance_m);

}  // namespace pleat::evaluate
