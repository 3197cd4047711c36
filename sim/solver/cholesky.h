#pragma once

#include <memory>
#include <vector>

#include "sim/solver/block_matrix.h"

namespace pleat::sim {

// Sparse Cholesky factor of matrices of about the same pattern: ordered once (METIS on the graph of
// vertices), analysed again where a matrix has blocks outside the pattern so far, factored often.
// Only user of SuiteSparse (CHOLMOD, supernodal).
class Cholesky {
 public:
  explicit Cholesky(const BlockMatrix& pattern);
  ~Cholesky();
  Cholesky(const Cholesky&) = delete;
  Cholesky& operator=(const Cholesky&) = delete;

  // Factors matrix + diag(shift), one shift a vertex. False where that is not positive definite:
  // then solve_roughly goes on with the last one that was, if the pattern is the same.
  bool factor(const BlockMatrix& matrix, const Eigen::VectorXd& shift);
  bool has_factor() const;  // whether there is something to solve with
  Eigen::VectorXd solve(const Eigen::VectorXd& right_side) const;
  // The same in single precision, in half the time: to precondition with.
  void solve_roughly(const Eigen::VectorXd& right_side, Eigen::VectorXd& solution) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pleat::sim
