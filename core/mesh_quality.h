// What certifies a drape and scores a sample alike: strain, distance to the body, intersections.
#pragma once

#include "core/proximity.h"
#include "core/types.h"

namespace pleat {

struct Strain {
  double max = 0;  // largest |principal stretch - 1| over the faces that stretch
  double percentile_95 =
      0;  // of the larger principal stretch - 1, over faces, negative clamped to 0
};
// rest: flat rest position of each corner (corner_rest row = panel vertex), m; rest_faces: the same
// faces into rest.
Strain strain(const Eigen::Ref<const Points3>& vertices, const Faces& faces,
              const Eigen::Ref<const Points2>& rest, const Faces& rest_faces);

// Signed distance of each point to a closed surface (negative inside), by closest point and
// angle-weighted pseudonormal (Baerentzen and Aanaes 2005); exact within max_distance,
// +max_distance beyond it on the outside.
Eigen::VectorXd signed_distances(const SurfaceTree& surface,
                                 const Eigen::Ref<const Points3>& points, double max_distance);

}  // namespace pleat
