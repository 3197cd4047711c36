#pragma once

#include <memory>
#include <vector>

#include "sim/solver/block_matrix.h"

namespace pleat::sim {

// Sparse Cholesky factor of matrices of about the same pattern: ordered once (METIS on the graph of
// vertices), analysed again where a matrix has blocks outside the pattern so far, factored often:
// in double precision by CHOLMOD, which tells whether a matrix is positive definite, or roughly, in
// single precision over CHOLMOD's analysis, which is twice as fast and serves to precondition with.
// Only user of SuiteSparse and BLAS.
class Cholesky {
 public:
  explicit Cholesky(const BlockMatrix& pattern);
  ~Cholesky();
  Cholesky(const Cholesky&) = delete;
  Cholesky& operator=(const Cholesky&) = delete;

  // Factors matrix + diag(shift), one shift a vertex. False where that is not positive definite:
  // then there is no factor until one succeeds. Each gives up the factor of the other kind, which
  // would lie beside it in memory.
  bool factor(const BlockMatrix& matrix, const Eigen::VectorXd& shift);
  bool factor_roughly(const BlockMatrix& matrix, const Eigen::VectorXd& shift);
  // With the factor of its kind, if that is the last.
  Eigen::VectorXd solve(const Eigen::VectorXd& right_side) const;
  void solve_roughly(const Eigen::VectorXd& right_side, Eigen::VectorXd& solution) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pleat::sim
