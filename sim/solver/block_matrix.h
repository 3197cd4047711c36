// Sparse symmetric matrix of 3 x 3 blocks, one row of blocks a vertex, both triangles stored,
// columns ascending.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "core/types.h"

namespace pleat::sim {

struct BlockMatrix {
  std::vector<int> row_start;  // #V + 1
  std::vector<int> column;     // of each block
  std::vector<double> values;  // 9 a block, row-major; symmetric blocks lie on the diagonal
  std::vector<int> diagonal;   // #V: index of each vertex's own block

  int rows() const { return row_start.empty() ? 0 : static_cast<int>(row_start.size()) - 1; }
  int block_count() const { return static_cast<int>(column.size()); }
  // Index of block (row, column), which must be in the pattern.
  int find(int row, int column) const;
  bool has(int row, int column) const;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(int index) {
    return Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data() + 9 * index);
  }
  Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> block(int index) const {
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data() +
                                                                          9 * index);
  }
};

// The pattern in which every pair of vertices of the given groups is coupled; values zero.
BlockMatrix make_pattern(int vertex_count, const std::vector<std::pair<int, int>>& coupled);

}  // namespace pleat::sim
