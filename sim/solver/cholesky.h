#pragma once

#include <memory>
#include <vector>

#include "sim/solver/block_matrix.h"

namespace pleat::sim {

// Sparse Cholesky factor of matrices that share one pattern: ordered and analysed once (METIS on
// the graph of vertices), factored often. Only user of SuiteSparse (CHOLMOD, supernodal).
class Cholesky {
 public:
  explicit Cholesky(const BlockMatrix& pattern);
  // The same with a given order of elimination, one that is good for nearly the same pattern.
  Cholesky(const BlockMatrix& pattern, const std::vector<int>& order);
  ~Cholesky();
  Cholesky(const Cholesky&) = delete;
  Cholesky& operator=(const Cholesky&) = delete;

  // Factors matrix + diag(shift), one shift a vertex. False where that is not positive definite.
  bool factor(const BlockMatrix& matrix, const Eigen::VectorXd& shift);
  const std::vector<int>& order() const;  // vertices as they are eliminated
  Eigen::VectorXd solve(const Eigen::VectorXd& right_side) const;
  // The same in single precision, in half the time: to precondition with.
  void solve_roughly(const Eigen::VectorXd& right_side, Eigen::VectorXd& solution) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pleat::sim
