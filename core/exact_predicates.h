// Exact signs of determinants, and what follows from them: whether two triangles meet.
#pragma once

#include <array>

#include "core/types.h"

namespace pleat {

// 1 where (a, b, c) runs clockwise seen from d (d is below the plane that sees a, b, c counter-
// clockwise from above), -1 where d is above, 0 where the four are exactly coplanar.
int orientation(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d);
// 1 where (a, b, c) runs counter-clockwise, -1 clockwise, 0 collinear.
int orientation(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c);

// Whether two closed triangles have a point in common. Degenerate ones count as segments and
// points.
bool triangles_meet(const std::array<Vec<3>, 3>& s, const std::array<Vec<3>, 3>& t);

}  // namespace pleat
