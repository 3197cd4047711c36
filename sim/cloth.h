// A cut and sewn cloth as elements of force: what does not change while it moves.
#pragma once

#include <array>
#include <vector>

#include "garment/fabric.h"
#include "sim/forces/bending.h"
#include "sim/forces/membrane.h"
#include "sim/forces/weight.h"
#include "sim/solver/block_matrix.h"

namespace pleat::sim {

struct Cloth {
  int vertex_count = 0;
  Faces faces;           // into the sewn vertices
  Eigen::VectorXd area;  // m^2 of rest area lumped at each vertex
  std::vector<Weight> weights;
  std::vector<Membrane> membranes;
  std::vector<Bending> bendings;
  MembraneLaw membrane_law;
  BendingLaw bending_law;
  std::vector<std::vector<int>> membranes_of, bendings_of;  // #V: elements at each vertex
  std::vector<std::array<int, 9>>
      membrane_blocks;  // where each element's blocks (a, b) go, row-major in a
  std::vector<std::array<int, 16>> bending_blocks;  // the same; empty where the law is constant
  BlockMatrix bending_hessian;  // of a constant law, else zero; its pattern is the Hessian's
  double weight_norm = 0;       // N, length of the vector of all weights: the unit of residuals
  std::vector<char> is_pinned;  // #V: held where it is; empty: none
};

// faces: into the sewn vertices; panel_faces: the same faces into `panels`, m, flat.
// Bending acts across seams too, each side measured in its own panel. Panel axis 0 is the fabric's
// weft, axis 1 its warp.
Cloth make_cloth(const Faces& faces, const Faces& panel_faces,
                 const Eigen::Ref<const Points2>& panels, int vertex_count,
                 const garment::Fabric& fabric);

}  // namespace pleat::sim
