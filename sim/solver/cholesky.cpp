#include "sim/solver/cholesky.h"

#include <cholmod.h>
#include <dlfcn.h>
#include <omp.h>

#include <algorithm>
#include <mutex>
#include <new>
#include <stdexcept>
#include <vector>

// BLAS and LAPACK, matrices by columns.
extern "C" {
void sgemm_(const char*, const char*, const int*, const int*, const int*, const float*,
            const float*, const int*, const float*, const int*, const float*, float*, const int*);
void ssyrk_(const char*, const char*, const int*, const int*, const float*, const float*,
            const int*, const float*, float*, const int*);
void strsm_(const char*, const char*, const char*, const char*, const int*, const int*,
            const float*, const float*, const int*, float*, const int*);
void sgemv_(const char*, const int*, const int*, const float*, const float*, const int*,
            const float*, const int*, const float*, float*, const int*);
void strsv_(const char*, const char*, const char*, const int*, const float*, const int*, float*,
            const int*);
void spotrf_(const char*, const int*, float*, const int*, int*);
}

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
  // Columns first .. first + columns of the factor: dense, by columns, as high as `rows` are many,
  // the first of which are those columns; from `start` on in the factor's numbers.
  struct Supernode {
    int first, columns, height;
    const int* rows;
    int start;
  };

  cholmod_common common;
  cholmod_sparse* matrix = nullptr;  // lower triangle, column-compressed
  cholmod_factor* factor = nullptr;
  std::vector<int> order;               // vertices as they are eliminated
  std::vector<int> block_start, block;  // pattern: each vertex's own block and those right of it
  // In single precision, over CHOLMOD's supernodes: the numbers, empty where there is no such
  // factor, which supernode each column is in, and where each vertex's first unknown is eliminated.
  std::vector<float> rough;
  std::vector<int> supernode, place;
  mutable Eigen::VectorXf work, gathered;

  Impl() {
    keep_blas_single();
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

  void fill_values(const BlockMatrix& from, const Eigen::VectorXd& shift) {
    double* values = static_cast<double*>(matrix->x);
    std::fill(values, values + matrix->nzmax, 0.0);
    for (int j = 0; j < from.rows(); ++j) {
      int k = block_start[j];
      for (int b = from.diagonal[j]; b < from.row_start[j + 1]; ++b) {
        while (block[k] != from.column[b]) ++k;
        for (int c = 0; c < 3; ++c)
          for (int r = block[k] == j ? c : 0; r < 3; ++r)
            values[entry(j, c, k, r)] = from.values[9 * b + 3 * c + r];
      }
      for (int c = 0; c < 3; ++c) values[entry(j, c, block_start[j], c)] += shift[j];
    }
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
    const int unknowns = static_cast<int>(factor->n);
    const int* permutation = static_cast<const int*>(factor->Perm);
    place.resize(unknowns / 3);
    for (int p = 0; p < unknowns; p += 3) {
      place[permutation[p] / 3] = p;
      for (int c = 0; c < 3; ++c)
        if (permutation[p + c] != 3 * (permutation[p] / 3) + c)
          throw std::runtime_error("CHOLMOD has taken a vertex's unknowns apart");
    }
    const int* super = static_cast<const int*>(factor->super);
    supernode.clear();
    for (int s = 0; s < static_cast<int>(factor->nsuper); ++s)
      supernode.insert(supernode.end(), super[s + 1] - super[s], s);
  }

  bool covers(const BlockMatrix& matrix) const {
    for (int j = 0; j < matrix.rows(); ++j) {
      int k = block_start[j];
      for (int b = matrix.diagonal[j]; b < matrix.row_start[j + 1]; ++b) {
        while (k < block_start[j + 1] && block[k] != matrix.column[b]) ++k;
        if (k == block_start[j + 1]) return false;
      }
    }
    return true;
  }

  void make_room(const BlockMatrix& for_matrix) {
    if (covers(for_matrix)) return;
    fill_pattern(for_matrix);
    analyse();
  }

  Supernode at(int s) const {
    const int* super = static_cast<const int*>(factor->super);
    const int* row_start = static_cast<const int*>(factor->pi);
    return {super[s], super[s + 1] - super[s], row_start[s + 1] - row_start[s],
            static_cast<const int*>(factor->s) + row_start[s],
            static_cast<const int*>(factor->px)[s]};
  }

  // Left-looking: each supernode takes its part of the matrix, what the supernodes before it take
  // off, and is factored (Ng and Peyton 1993, "Block sparse Cholesky algorithms on advanced
  // uniprocessor computers").
  bool factor_roughly(const BlockMatrix& from, const Eigen::VectorXd& shift) {
    const float one = 1, zero = 0;
    const int supernodes = static_cast<int>(factor->nsuper);
    const int* permutation = static_cast<const int*>(factor->Perm);
    rough.assign(factor->xsize, 0);
    // Supernodes that take something off s next are in a list from first[s] on; done[d]: rows of d
    // that lie in the supernodes so far.
    std::vector<int> first(supernodes, -1), next(supernodes, -1), done(supernodes);
    std::vector<int> where(factor->n), target;  // of each row in the supernode at work
    std::vector<float> taken;
    const auto pass_on = [&](int d) {
      const Supernode node = at(d);
      if (done[d] == node.height) return;
      const int to = supernode[node.rows[done[d]]];
      next[d] = first[to];
      first[to] = d;
    };
    for (int s = 0; s < supernodes; ++s) {
      const Supernode node = at(s);
      float* values = rough.data() + node.start;
      for (int i = 0; i < node.height; ++i) where[node.rows[i]] = i;
      for (int column = 0; column < node.columns; column += 3) {
        const int p = node.first + column, v = permutation[p] / 3;
        for (int b = from.row_start[v]; b < from.row_start[v + 1]; ++b) {
          const int q = place[from.column[b]];
          if (q < p) continue;
          for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r)
              values[(column + c) * node.height + where[q] + r] =
                  static_cast<float>(from.values[9 * b + 3 * c + r]);
        }
        for (int c = 0; c < 3; ++c)
          values[(column + c) * (node.height + 1)] += static_cast<float>(shift[v]);
      }
      for (int d = first[s], after; d >= 0; d = after) {
        after = next[d];
        const Supernode by = at(d);
        const int* rows = by.rows + done[d];
        const int height = by.height - done[d];
        int width = 0;
        while (width < height && rows[width] < node.first + node.columns) ++width;
        const float* part = rough.data() + by.start + done[d];
        taken.resize(std::max(taken.size(), static_cast<size_t>(height) * width));
        ssyrk_("L", "N", &width, &by.columns, &one, part, &by.height, &zero, taken.data(), &height);
        const int below = height - width;
        if (below > 0)
          sgemm_("N", "T", &below, &width, &by.columns, &one, part + width, &by.height, part,
                 &by.height, &zero, taken.data() + width, &height);
        target.resize(std::max(target.size(), static_cast<size_t>(height)));
        for (int i = 0; i < height; ++i) target[i] = where[rows[i]];
        for (int j = 0; j < width; ++j) {
          float* into = values + (rows[j] - node.first) * node.height;
          const float* off = taken.data() + j * height;
          for (int i = j; i < height; ++i) into[target[i]] -= off[i];
        }
        done[d] += width;
        pass_on(d);
      }
      int failed = 0;
      spotrf_("L", &node.columns, values, &node.height, &failed);
      if (failed != 0) {
        rough.clear();
        return false;
      }
      const int below = node.height - node.columns;
      if (below > 0)
        strsm_("R", "L", "T", "N", &below, &node.columns, &one, values, &node.height,
               values + node.columns, &node.height);
      done[s] = node.columns;
      pass_on(s);
    }
    return true;
  }
};

Cholesky::Cholesky(const BlockMatrix& pattern) : impl_(std::make_unique<Impl>()) {
  const SingleThread single_thread;
  impl_->fill_pattern(pattern);
  impl_->order = impl_->reduce_fill(pattern);
  impl_->analyse();
}

Cholesky::~Cholesky() = default;

bool Cholesky::factor(const BlockMatrix& matrix, const Eigen::VectorXd& shift) {
  const SingleThread single_thread;
  std::vector<float>().swap(impl_->rough);
  impl_->make_room(matrix);
  impl_->fill_values(matrix, shift);
  const bool is_done = cholmod_factorize(impl_->matrix, impl_->factor, &impl_->common);
  impl_->require_memory();
  return is_done && impl_->common.status == CHOLMOD_OK;
}

bool Cholesky::factor_roughly(const BlockMatrix& matrix, const Eigen::VectorXd& shift) {
  const SingleThread single_thread;
  // What is left is the analysis.
  cholmod_change_factor(CHOLMOD_PATTERN, 1, 1, 0, 0, impl_->factor, &impl_->common);
  impl_->make_room(matrix);
  return impl_->factor_roughly(matrix, shift);
}

void Cholesky::solve_roughly(const Eigen::VectorXd& right_side, Eigen::VectorXd& solution) const {
  const cholmod_factor& factor = *impl_->factor;
  const int* permutation = static_cast<const int*>(factor.Perm);
  const Eigen::Index count = right_side.size();
  Eigen::VectorXf &y = impl_->work, &gathered = impl_->gathered;
  y.resize(count);
  gathered.resize(factor.maxesize);
  for (Eigen::Index i = 0; i < count; ++i) y[i] = static_cast<float>(right_side[permutation[i]]);
  const int supernodes = static_cast<int>(factor.nsuper), step = 1;
  const float one = 1, minus = -1, zero = 0;
  for (int s = 0; s < supernodes; ++s) {
    const Impl::Supernode node = impl_->at(s);
    const int below = node.height - node.columns;
    const float* values = impl_->rough.data() + node.start;
    float* head = y.data() + node.first;
    strsv_("L", "N", "N", &node.columns, values, &node.height, head, &step);
    if (below == 0) continue;
    sgemv_("N", &below, &node.columns, &one, values + node.columns, &node.height, head, &step,
           &zero, gathered.data(), &step);
    const int* row = node.rows + node.columns;
    for (int i = 0; i < below; ++i) y[row[i]] -= gathered[i];
  }
  for (int s = supernodes - 1; s >= 0; --s) {
    const Impl::Supernode node = impl_->at(s);
    const int below = node.height - node.columns;
    const float* values = impl_->rough.data() + node.start;
    float* head = y.data() + node.first;
    if (below > 0) {
      const int* row = node.rows + node.columns;
      for (int i = 0; i < below; ++i) gathered[i] = y[row[i]];
      sgemv_("T", &below, &node.columns, &minus, values + node.columns, &node.height,
             gathered.data(), &step, &one, head, &step);
    }
    strsv_("L", "T", "N", &node.columns, values, &node.height, head, &step);
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
