#include "sim/solver/cholesky.h"

#include <cholmod.h>
#include <omp.h>

#include <numeric>
#include <stdexcept>
#include <vector>

namespace pleat::sim {
namespace {

// CHOLMOD's supernodal code opens OpenMP regions of its own; a drape owns one thread.
class SingleThread {
 public:
  SingleThread() : levels_(omp_get_max_active_levels()) { omp_set_max_active_levels(0); }
  ~SingleThread() { omp_set_max_active_levels(levels_); }

 private:
  int levels_;
};

}  // namespace

struct Cholesky::Impl {
  cholmod_common common;
  cholmod_sparse* matrix = nullptr;  // lower triangle, column-compressed
  cholmod_factor* factor = nullptr;
  std::vector<int> source;    // entry of `matrix` -> value in BlockMatrix::values
  std::vector<int> diagonal;  // unknown -> entry of `matrix`

  Impl() {
    cholmod_start(&common);
    common.print = 0;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.final_ll = 1;
    common.quick_return_if_not_posdef = 1;
  }
  ~Impl() {
    cholmod_free_factor(&factor, &common);
    cholmod_free_sparse(&matrix, &common);
    cholmod_finish(&common);
  }

  // Column 3j+c of the lower triangle lists block row j's blocks at or right of the diagonal
  // (symmetry).
  void fill_pattern(const BlockMatrix& pattern) {
    const int vertices = pattern.rows(), unknowns = 3 * vertices;
    std::vector<int> start(1, 0), row;
    for (int j = 0; j < vertices; ++j)
      for (int c = 0; c < 3; ++c) {
        for (int k = pattern.diagonal[j]; k < pattern.row_start[j + 1]; ++k)
          for (int r = 0; r < 3; ++r) {
            if (pattern.column[k] == j && r < c) continue;
            if (pattern.column[k] == j && r == c) diagonal.push_back(static_cast<int>(row.size()));
            row.push_back(3 * pattern.column[k] + r);
            source.push_back(9 * k + 3 * c + r);
          }
        start.push_back(static_cast<int>(row.size()));
      }
    matrix =
        cholmod_allocate_sparse(unknowns, unknowns, row.size(), 1, 1, -1, CHOLMOD_REAL, &common);
    std::copy(start.begin(), start.end(), static_cast<int*>(matrix->p));
    std::copy(row.begin(), row.end(), static_cast<int*>(matrix->i));
  }

  // Fill-reducing order of the vertices, each of which then gives its three unknowns.
  std::vector<int> order(const BlockMatrix& pattern) {
    const int vertices = pattern.rows();
    cholmod_sparse* graph = cholmod_allocate_sparse(vertices, vertices, pattern.column.size(), 1, 1,
                                                    -1, CHOLMOD_PATTERN, &common);
    int* start = static_cast<int*>(graph->p);
    int* row = static_cast<int*>(graph->i);
    int count = 0;
    for (int j = 0; j < vertices; ++j) {
      start[j] = count;
      for (int k = pattern.diagonal[j]; k < pattern.row_start[j + 1]; ++k)
        row[count++] = pattern.column[k];
    }
    start[vertices] = count;
    std::vector<int> permutation(vertices);
    if (!cholmod_metis(graph, nullptr, 0, 1, permutation.data(), &common))
      std::iota(permutation.begin(), permutation.end(), 0);
    cholmod_free_sparse(&graph, &common);
    std::vector<int> expanded;
    for (int v : permutation)
      for (int c = 0; c < 3; ++c) expanded.push_back(3 * v + c);
    return expanded;
  }
};

Cholesky::Cholesky(const BlockMatrix& pattern) : impl_(std::make_unique<Impl>()) {
  const SingleThread single_thread;
  impl_->fill_pattern(pattern);
  std::vector<int> permutation = impl_->order(pattern);
  impl_->common.nmethods = 1;
  impl_->common.method[0].ordering = CHOLMOD_GIVEN;
  impl_->factor = cholmod_analyze_p(impl_->matrix, permutation.data(), nullptr, 0, &impl_->common);
  if (!impl_->factor) throw std::runtime_error("CHOLMOD could not analyse the pattern");
}

Cholesky::~Cholesky() = default;

bool Cholesky::factor(const BlockMatrix& matrix, const Eigen::VectorXd& shift) {
  const SingleThread single_thread;
  double* values = static_cast<double*>(impl_->matrix->x);
  for (size_t e = 0; e < impl_->source.size(); ++e) values[e] = matrix.values[impl_->source[e]];
  for (size_t u = 0; u < impl_->diagonal.size(); ++u) values[impl_->diagonal[u]] += shift[u / 3];
  return cholmod_factorize(impl_->matrix, impl_->factor, &impl_->common) &&
         impl_->common.status == CHOLMOD_OK;
}

Eigen::VectorXd Cholesky::solve(const Eigen::VectorXd& right_side) const {
  const SingleThread single_thread;
  cholmod_dense b = {};
  b.nrow = b.nzmax = b.d = right_side.size();
  b.ncol = 1;
  b.x = const_cast<double*>(right_side.data());
  b.xtype = CHOLMOD_REAL;
  cholmod_dense* x = cholmod_solve(CHOLMOD_A, impl_->factor, &b, &impl_->common);
  if (!x) throw std::runtime_error("CHOLMOD could not solve");
  Eigen::VectorXd solution =
      Eigen::Map<Eigen::VectorXd>(static_cast<double*>(x->x), right_side.size());
  cholmod_free_dense(&x, &impl_->common);
  return solution;
}

}  // namespace pleat::sim
