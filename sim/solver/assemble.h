// The forces on a cloth, and their sum: energy, gradient and sparse Hessian.
#pragma once

#include <array>
#include <vector>

#include "garment/fabric.h"
#include "sim/forces/bending.h"
#include "sim/forces/contact.h"
#include "sim/forces/friction.h"
#include "sim/forces/membrane.h"
#include "sim/forces/weight.h"
#include "sim/solver/block_matrix.h"

namespace pleat::sim {

// A cut and sewn cloth as elements of force; what does not change while it moves.
struct Cloth {
  int vertex_count = 0;
  Eigen::VectorXd area;  // m^2 of rest area lumped at each vertex
  std::vector<Weight> weights;
  std::vector<Membrane> membranes;
  std::vector<Bending> bendings;
  MembraneLaw membrane_law;
  BendingLaw bending_law;
  std::vector<std::array<int, 9>>
      membrane_blocks;  // where each element's blocks (a, b) go, row-major in a
  std::vector<std::array<int, 16>> bending_blocks;  // the same; empty where the law is constant
  BlockMatrix bending_hessian;  // of a constant law, else zero; its pattern is the Hessian's
  double total_weight = 0;      // N
};

// faces: into the sewn vertices; panel_faces: the same faces into `panels`, m, flat.
// Bending acts across seams too, each side measured in its own panel. Panel axis 0 is the fabric's
// weft, axis 1 its warp.
Cloth make_cloth(const Faces& faces, const Faces& panel_faces,
                 const Eigen::Ref<const Points2>& panels, int vertex_count,
                 const garment::Fabric& fabric);

// The touching vertices of one configuration, frozen within a solver iteration.
struct Touching {
  std::vector<Contact> contacts;
  std::vector<Friction> frictions;  // the i-th belongs to the i-th contact; further contacts of a
                                    // vertex that other parts of the body squeeze have none
};

struct System {
  double energy = 0;         // J
  Eigen::VectorXd gradient;  // 3#V, J/m
  BlockMatrix hessian;       // filled from Order::kProjectedHessian on
};

// Sums in a fixed order, so equal input gives equal bits. One drape runs on one thread; campaigns
// run many drapes at once.
void assemble(const Cloth& cloth, const Touching& touching, const Eigen::VectorXd& x, Order order,
              System& system);

}  // namespace pleat::sim
