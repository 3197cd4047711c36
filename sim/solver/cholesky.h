#pragma once

#include <memory>

#include "sim/solver/block_matrix.h"

namespace pleat::sim {

// Sparse Cholesky factor of matrices that share one pattern: ordered and analysed once (METIS on
// the graph of vertices), factored often. Only user of SuiteSparse (CHOLMOD, supernodal).
class Cholesky {
 public:
  explicit Cholesky(const BlockMatrix& pattern);
  ~Cholesky();
  Cholesky(const Cholesky&) = delete;
  Cholesky& operator=(const Cholesky&) = delete;

  // Factors matrix + diag(shift), one shift a vertex. False where that is not positive definite.
  bool factor(const BlockMatrix& matrix, const Eigen::VectorXd& shift);
  Eigen::VectorXd solve(const Eigen::VectorXd& right_side) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pleat::sim
