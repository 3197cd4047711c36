#pragma once

#include <vector>

#include "core/types.h"

namespace pleat::body {

// Faces over a subset of the same vertices, fewer, as close to the old surface as can be: edges are
// collapsed onto one of their ends in the order of Garland and Heckbert's quadric error (1997), as
// long as the surface stays a manifold (link condition), no face turns over and none becomes a
// sliver. Only vertices with may_go disappear; faces without any stay as they are. Ends at
// target_face_count, or above it where nothing more can go.
Faces thin_surface(const Eigen::Ref<const Points3>& vertices, const Faces& faces,
                   const std::vector<char>& may_go, int target_face_count);

}  // namespace pleat::body
