// The smooth one-to-one map from the reference panel to the same panel of a design. It knows no
// triangles, so every tessellation, and a user's own mesh with our UVs, gets the same cloth.
#pragma once

#include "core/types.h"
#include "garment/pattern.h"

namespace pleat::garment {

// points: # x 2, m, on the reference panel. Composite mean value mapping (Schneider, Hormann and
// Floater 2013): the reference outline turns into the design's in small steps, each a mean value
// mapping between two polygons; the outline itself is mapped linearly, segment by segment.
Points2 map_to_design(Panel panel, const Eigen::Ref<const Points2>& points, const Design& design);

}  // namespace pleat::garment
