// The forces on a cloth, or on a part of it, and their sum: energy, gradient and sparse Hessian.
#pragma once

#include <vector>

#include "sim/cloth.h"
#include "sim/solver/contacts.h"

namespace pleat::sim {

// Part of a cloth that moves while the rest stands still.
struct Region {
  std::vector<int> vertices;             // ascending
  std::vector<int> membranes, bendings;  // elements that touch one of them, ascending
  std::vector<int> place;                // #V: of a vertex in `vertices`, -1 outside
};
Region whole(const Cloth& cloth);
// The seeds and what lies within so many steps of the Hessian's pattern around them.
Region around(const Cloth& cloth, const std::vector<int>& seeds, int steps);

struct System {
  double energy = 0;         // J, of the elements in the region
  Eigen::VectorXd gradient;  // 3#V, J/m; holds for the region's vertices; 0 where one is pinned
  BlockMatrix hessian;       // the same, without barriers; filled from Order::kProjectedHessian on
};

// barriers: evaluated at x, to the same order at least. Sums in a fixed order, so equal input gives
// equal bits. One drape runs on one thread; campaigns run many drapes at once.
void assemble(const Cloth& cloth, const Region& region, const Touching& touching,
              const std::vector<ActiveBarrier>& barriers, const Eigen::VectorXd& x, Order order,
              System& system);

}  // namespace pleat::sim
