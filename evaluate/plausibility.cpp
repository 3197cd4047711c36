#include "evaluate/plausibility.h"

#include <algorithm>

namespace pleat::evaluate {

Plausibility plausibility(const garment::Garment& garment,
                          const Eigen::Ref<const Points3>& vertices, const SurfaceTree& body,
                          double search_distance_m) {
  Plausibility result;
  const Eigen::VectorXd gaps = signed_distances(body, vertices, search_distance_m);
  double depth_sum = 0;
  int inside = 0;
  for (const double gap : gaps) {
    if (gap >= 0) continue;
    ++inside;
    depth_sum -= gap;
    result.max_depth_mm = std::max(result.max_depth_mm, -1000 * gap);
  }
  if (inside > 0) {
    result.inside_share = static_cast<double>(inside) / static_cast<double>(gaps.size());
    result.mean_depth_mm = 1000 * depth_sum / inside;
  }
  const SurfaceTree cloth(vertices, garment.topology.faces);
  int last_face = -1;
  for (const auto& [cloth_face, body_face] :
       intersecting_faces(cloth, body)) {  // ascending by cloth face
    if (cloth_face != last_face) ++result.body_intersections;
    last_face = cloth_face;
  }
  result.strain =
      strain(vertices, garment.topology.faces, garment.panels, garment.topology.panel_faces);
  return result;
}

}  // namespace pleat::evaluate
