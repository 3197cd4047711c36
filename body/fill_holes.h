// Closes openings of a surface that ought to be closed: eye sockets, mouths.
#pragma once

#include <vector>

#include "core/types.h"

namespace pleat::body {

// Each opening as its vertices in the order in which filling faces run along it. Throws InputError
// where an opening meets itself in a vertex.
std::vector<std::vector<int>> boundary_loops(const Faces& faces);

// Triangles over the loop's own vertices, with the least total length of inner edges (Klincsek
// 1980), none of which the surface has already. Throws InputError where there is no such
// triangulation.
Faces fill_hole(const Eigen::Ref<const Points3>& vertices, const Faces& faces,
                const std::vector<int>& loop);

// The faces of a, then those of b.
Faces joined(const Faces& a, const Faces& b);

}  // namespace pleat::body
