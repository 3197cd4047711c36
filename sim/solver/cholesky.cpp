#include "sim/solver/cholesky.h"

#include <cholmod.h>
#include <dlfcn.h>
#include <omp.h>

#include <algorithm>
#include <mutex>
#include <new>
#include <stdexcept>
#include <vector>

namespace pleat::sim {
namespace {

// A drape owns one thread, and the bits of a sum must not depend on how many there are. OpenBLAS
// built without threads is not safe to call from several; the one with them can be told to use one.
void keep_blas_single() {
  static const bool is_told = [] {
    const auto set =
        reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
    if (set) set(1);
    return true;
  }();
  static_cast<void>(is_told);
}

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
  std::vector<int> order;               // vertices as they are eliminated
  std::vector<int> block_start, block;  // pattern: each vertex's own block and those right of it
  std::vector<float> rough;             // the factor's numbers in single precision
  mutable Eigen::VectorXf work, gathered;

  Impl() {
    keep_blas_single();
    cholmod_start(&common);
    common.print = 0;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.final_ll = 1;
    common.quick_return_if_not_posdef = 1;
    // Wider supernodes: a tenth faster on cloth of 5,000 vertices than with the defaults.
    common.nrelax[0] = 12;
    common.nrelax[1] = 48;
    common.nrelax[2] = 144;
    common.zrelax[0] = 0.8;
    common.zrelax[1] = 0.2;
    common.zrelax[2] = 0.05;
  }
  ~Impl() {
    cholmod_free_factor(&factor, &common);
    cholmod_free_sparse(&matrix, &common);
    cholmod_finish(&common);
  }

  // After each call that allocates.
  void require_memory() const {
    if (common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  }

  // Where entry (3 block[k] + r, 3 j + c) of the lower triangle lies, k being one of vertex j's
  // blocks: a column lists its own block from the diagonal down, then the others whole.
  int entry(int j, int c, int k, int r) const {
    const int nth = k - block_start[j];
    return static_cast<const int*>(matrix->p)[3 * j + c] +
           (nth == 0 ? r - c : 3 - c + 3 * (nth - 1) + r);
  }

  void fill_pattern(const BlockMatrix& pattern) {
    const int vertices = pattern.rows(), unknowns = 3 * vertices;
    block_start.assign(1, 0);
    block.clear();
    for (int j = 0; j < vertices; ++j) {
      block.insert(block.end(), pattern.column.begin() + pattern.diagonal[j],
                   pattern.column.begin() + pattern.row_start[j + 1]);
      block_start.push_back(static_cast<int>(block.size()));
    }
    cholmod_free_sparse(&matrix, &common);
    matrix = cholmod_allocate_sparse(unknowns, unknowns, 9 * block.size() - 3 * vertices, 1, 1, -1,
                                     CHOLMOD_REAL, &common);
    require_memory();
    int *start = static_cast<int*>(matrix->p), *row = static_cast<int*>(matrix->i), count = 0;
    for (int j = 0; j < vertices; ++j)
      for (int c = 0; c < 3; ++c) {
        start[3 * j + c] = count;
        for (int k = block_start[j]; k < block_start[j + 1]; ++k)
          for (int r = block[k] == j ? c : 0; r < 3; ++r) row[count++] = 3 * block[k] + r;
      }
    start[unknowns] = count;
  }

  // False where the pattern has no place for some block.
  bool fill_values(const BlockMatrix& from, const Eigen::VectorXd& shift) {
    double* values = static_cast<double*>(matrix->x);
    std::fill(values, values + matrix->nzmax, 0.0);
    for (int j = 0; j < from.rows(); ++j) {
      int k = block_start[j];
      for (int b = from.diagonal[j]; b < from.row_start[j + 1]; ++b, ++k) {
        while (k < block_start[j + 1] && block[k] != from.column[b]) ++k;
        if (k == block_start[j + 1]) return false;
        for (int c = 0; c < 3; ++c)
          for (int r = block[k] == j ? c : 0; r < 3; ++r)
            values[entry(j, c, k, r)] = from.values[9 * b + 3 * c + r];
      }
      for (int c = 0; c < 3; ++c) values[entry(j, c, block_start[j], c)] += shift[j];
    }
    return true;
  }

  // Fill-reducing order of the vertices.
  std::vector<int> reduce_fill(const BlockMatrix& pattern) {
    const int vertices = pattern.rows();
    cholmod_sparse* graph = cholmod_allocate_sparse(vertices, vertices, pattern.column.size(), 1, 1,
                                                    -1, CHOLMOD_PATTERN, &common);
    require_memory();
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
    // METIS draws from the C library's rand(), which it seeds at each call and which all threads
    // share: two orders found at once would be others each time, and with them the bits.
    static std::mutex one_at_a_time;
    const std::lock_guard<std::mutex> lock(one_at_a_time);
    const bool is_ordered = cholmod_metis(graph, nullptr, 0, 1, permutation.data(), &common);
    cholmod_free_sparse(&graph, &common);
    require_memory();
    if (!is_ordered) throw std::runtime_error("CHOLMOD could not order the pattern");
    return permutation;
  }

  void analyse() {
    std::vector<int> expanded;
    for (int v : order)
      for (int c = 0; c < 3; ++c) expanded.push_back(3 * v + c);
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_GIVEN;
    cholmod_free_factor(&factor, &common);
    factor = cholmod_analyze_p(matrix, expanded.data(), nullptr, 0, &common);
    rough.clear();
    require_memory();
    if (!factor) throw std::runtime_error("CHOLMOD could not analyse the pattern");
  }
};

Cholesky::Cholesky(const BlockMatrix& pattern) : impl_(std::make_unique<Impl>()) {
  const SingleThread single_thread;
  impl_->fill_pattern(pattern);
  impl_->order = impl_->reduce_fill(pattern);
  impl_->analyse();
}

Cholesky::~Cholesky() = default;

bool Cholesky::has_factor() const { return !impl_->rough.empty(); }

bool Cholesky::factor(const BlockMatrix& matrix, const Eigen::VectorXd& shift) {
  const SingleThread single_thread;
  if (!impl_->fill_values(matrix, shift)) {
    impl_->fill_pattern(matrix);
    impl_->analyse();
    impl_->fill_values(matrix, shift);
  }
  const bool is_done = cholmod_factorize(impl_->matrix, impl_->factor, &impl_->common);
  impl_->require_memory();
  if (!is_done || impl_->common.status != CHOLMOD_OK) return false;
  const double* exact = static_cast<const double*>(impl_->factor->x);
  impl_->rough.resize(impl_->factor->xsize);
  for (size_t i = 0; i < impl_->rough.size(); ++i) impl_->rough[i] = static_cast<float>(exact[i]);
  return true;
}

// Supernode s: columns super[s] .. super[s + 1] of the factor, dense, column-major, its rows listed
// in s[pi[s]] .., the first of them those columns.
void Cholesky::solve_roughly(const Eigen::VectorXd& right_side, Eigen::VectorXd& solution) const {
  const cholmod_factor& factor = *impl_->factor;
  const int* super = static_cast<const int*>(factor.super);
  const int* row_start = static_cast<const int*>(factor.pi);
  const int* value_start = static_cast<const int*>(factor.px);
  const int* rows = static_cast<const int*>(factor.s);
  const int* permutation = static_cast<const int*>(factor.Perm);
  const Eigen::Index count = right_side.size();
  Eigen::VectorXf &y = impl_->work, &gathered = impl_->gathered;
  y.resize(count);
  gathered.resize(factor.maxesize);
  for (Eigen::Index i = 0; i < count; ++i) y[i] = static_cast<float>(right_side[permutation[i]]);
  using Block = Eigen::Map<const Eigen::MatrixXf, 0, Eigen::OuterStride<>>;
  const int supernodes = static_cast<int>(factor.nsuper);
  for (int s = 0; s < supernodes; ++s) {
    const int first = super[s], columns = super[s + 1] - first;
    const int height = row_start[s + 1] - row_start[s], below = height - columns;
    const float* values = impl_->rough.data() + value_start[s];
    const Block triangle(values, columns, columns, Eigen::OuterStride<>(height));
    auto head = y.segment(first, columns);
    triangle.triangularView<Eigen::Lower>().solveInPlace(head);
    if (below == 0) continue;
    const Block rest(values + columns, below, columns, Eigen::OuterStride<>(height));
    gathered.head(below).noalias() = rest * head;
    const int* row = rows + row_start[s] + columns;
    for (int i = 0; i < below; ++i) y[row[i]] -= gathered[i];
  }
  for (int s = supernodes - 1; s >= 0; --s) {
    const int first = super[s], columns = super[s + 1] - first;
    const int height = row_start[s + 1] - row_start[s], below = height - columns;
    const float* values = impl_->rough.data() + value_start[s];
    auto head = y.segment(first, columns);
    if (below > 0) {
      const Block rest(values + columns, below, columns, Eigen::OuterStride<>(height));
      const int* row = rows + row_start[s] + columns;
      for (int i = 0; i < below; ++i) gathered[i] = y[row[i]];
      head.noalias() -= rest.transpose() * gathered.head(below);
    }
    const Block triangle(values, columns, columns, Eigen::OuterStride<>(height));
    triangle.transpose().triangularView<Eigen::Upper>().solveInPlace(head);
  }
  solution.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) solution[permutation[i]] = y[i];
}

Eigen::VectorXd Cholesky::solve(const Eigen::VectorXd& right_side) const {
  const SingleThread single_thread;
  cholmod_dense b = {};
  b.nrow = b.nzmax = b.d = right_side.size();
  b.ncol = 1;
  b.x = const_cast<double*>(right_side.data());
  b.xtype = CHOLMOD_REAL;
  cholmod_dense* x = cholmod_solve(CHOLMOD_A, impl_->factor, &b, &impl_->common);
  impl_->require_memory();
  if (!x) throw std::runtime_error("CHOLMOD could not solve");
  Eigen::VectorXd solution =
      Eigen::Map<Eigen::VectorXd>(static_cast<double*>(x->x), right_side.size());
  cholmod_free_dense(&x, &impl_->common);
  return solution;
}

}  // namespace pleat::sim
