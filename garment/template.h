// One topology and one UV layout for all designs; finer and coarser tessellations of it.
#pragma once

#include <string>
#include <vector>

#include "body/body_model.h"
#include "core/types.h"
#include "garment/design.h"
#include "garment/pattern.h"

namespace pleat::garment {

// What no design changes. Panels are cut separately ("panel vertices") and sewn: both sides of a
// seam are one vertex of the sewn mesh.
struct GarmentTopology {
  Faces faces;                         // #F x 3 into the sewn vertices
  Faces panel_faces;                   // #F x 3, the same faces into the panel vertices
  Eigen::VectorXi sewn_vertex;         // panel vertex -> sewn vertex
  std::vector<Panel> panel_of_vertex;  // of each panel vertex
  Points2 uv;                          // panel vertices in the layout, [0,1]^2
  int vertex_count = 0;                // sewn
};

// vertex_count: about how many sewn vertices (1200 .. 20000 are tested).
GarmentTopology make_topology(int vertex_count);

// The flat panels of one design: rest position of every panel vertex, m, in the plane of its panel
// (y up the body).
Points2 cut_panels(const GarmentTopology& topology, const Design& design);

// Where the sewn vertices start around the T-posed body, outside of it everywhere: the solver
// settles it from there.
Points3 place_around_body(const GarmentTopology& topology, const Points2& panels,
                          const body::BodyModel& model, const body::ShapedBody& body);

// A design, sewn and settled on the mean body in the T-pose: the template from which offsets are
// taken.
struct Garment {
  Design design;
  GarmentTopology topology;
  Points2 panels;       // panel vertices, m, flat
  Points3 t_pose;       // sewn vertices, m, T-pose of the mean body
  SkinWeights weights;  // sewn vertices x 24
};

}  // namespace pleat::garment
