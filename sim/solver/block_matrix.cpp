#include "sim/solver/block_matrix.h"

#include <algorithm>
#include <cassert>

namespace pleat::sim {

int BlockMatrix::find(int row, int wanted) const {
  const auto begin = column.begin() + row_start[row], end = column.begin() + row_start[row + 1];
  const auto found = std::lower_bound(begin, end, wanted);
  assert(found != end && *found == wanted);
  return static_cast<int>(found - column.begin());
}

bool BlockMatrix::has(int row, int wanted) const {
  return std::binary_search(column.begin() + row_start[row], column.begin() + row_start[row + 1],
                            wanted);
}

BlockMatrix make_pattern(int vertex_count, const std::vector<std::pair<int, int>>& coupled) {
  std::vector<std::vector<int>> columns(vertex_count);
  for (int v = 0; v < vertex_count; ++v) columns[v].push_back(v);
  for (const auto& [a, b] : coupled) {
    columns[a].push_back(b);
    columns[b].push_back(a);
  }
  BlockMatrix matrix;
  matrix.row_start.push_back(0);
  for (int v = 0; v < vertex_count; ++v) {
    std::sort(columns[v].begin(), columns[v].end());
    columns[v].erase(std::unique(columns[v].begin(), columns[v].end()), columns[v].end());
    matrix.column.insert(matrix.column.end(), columns[v].begin(), columns[v].end());
    matrix.row_start.push_back(static_cast<int>(matrix.column.size()));
  }
  matrix.values.assign(9 * matrix.column.size(), 0.0);
  for (int v = 0; v < vertex_count; ++v) matrix.diagonal.push_back(matrix.find(v, v));
  return matrix;
}

void multiply(const BlockMatrix& matrix, const Eigen::VectorXd& x, Eigen::VectorXd& y) {
  y.resize(x.size());
  const double* value = matrix.values.data();
  for (int row = 0; row < matrix.rows(); ++row) {
    double s0 = 0, s1 = 0, s2 = 0;
    for (int k = matrix.row_start[row]; k < matrix.row_start[row + 1]; ++k, value += 9) {
      const double* p = x.data() + 3 * matrix.column[k];
      s0 += value[0] * p[0] + value[1] * p[1] + value[2] * p[2];
      s1 += value[3] * p[0] + value[4] * p[1] + value[5] * p[2];
      s2 += value[6] * p[0] + value[7] * p[1] + value[8] * p[2];
    }
    y[3 * row] = s0;
    y[3 * row + 1] = s1;
    y[3 * row + 2] = s2;
  }
}

}  // namespace pleat::sim
