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

}  // namespace pleat::sim
