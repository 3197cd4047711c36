// Newton's linear system on a region, held in parts: products with it, and what preconditions them.
#pragma once

#include <vector>

#include "sim/solver/assemble.h"

namespace pleat::sim {

// Vectors have 3 entries a vertex of the region, in its order.
struct NewtonSystem {
  const Cloth& cloth;
  const Region& region;
  const BlockMatrix& matrix;
  const std::vector<ActiveBarrier>& barriers;
};

void multiply(const NewtonSystem& system, const Eigen::VectorXd& p, Eigen::VectorXd& result);

// The matrix with the barriers' blocks: in its own pattern where they couple no two vertices of the
// cloth, else in a wider one.
BlockMatrix with_barriers(const NewtonSystem& system);

// Inverses of the 3 x 3 blocks on the diagonal, made positive definite by the absolute values of
// their eigenvalues.
std::vector<Mat<3>> inverse_blocks(const NewtonSystem& system);

// Gathers the region's rows of a vector of the whole cloth, and scatters them back.
Eigen::VectorXd restrict_to(const Region& region, const Eigen::VectorXd& whole);
void spread(const Region& region, const Eigen::VectorXd& part, Eigen::VectorXd& whole);

}  // namespace pleat::sim
