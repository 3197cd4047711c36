// Triangulates one flat panel, exactly mirror-symmetric about x = 0 (only user of Qhull).
#pragma once

#include <array>
#include <vector>

#include "core/types.h"

namespace pleat::garment {

struct PanelMesh {
  Points2 points;  // m, panel plane
  Faces faces;     // counter-clockwise
  // Vertices along each curve of the half outline, in its order: [curve][0] on x >= 0, [curve][1]
  // their mirror images.
  std::vector<std::array<std::vector<int>, 2>> curves;
};

// half_outline: from pattern.h. Its curves are cut into equal segments of about `spacing`, the same
// number wherever the curve is equally long; the interior is a triangular lattice, relaxed. No
// triangle has its three corners on the outline.
PanelMesh mesh_panel(const Points2& half_outline, double spacing);

// What mesh_panel will make, without making it.
struct PanelCount {
  int vertices = 0;
  std::vector<int> segments;  // of each curve
};
PanelCount count_panel(const Points2& half_outline, double spacing);

}  // namespace pleat::garment
