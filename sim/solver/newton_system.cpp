#include "sim/solver/newton_system.h"

#include <algorithm>

namespace pleat::sim {
namespace {

// Where the four vertices of a barrier stand in the region; -1: on the body or outside.
std::array<int, 4> places(const NewtonSystem& system, const ActiveBarrier& barrier) {
  std::array<int, 4> result;
  for (int k = 0; k < 4; ++k) {
    const int v = barrier.element.vertices[k];
    result[k] = v < system.cloth.vertex_count ? system.region.place[v] : -1;
  }
  return result;
}

}  // namespace

void multiply(const NewtonSystem& system, const Eigen::VectorXd& p, Eigen::VectorXd& result) {
  const Region& region = system.region;
  const BlockMatrix& matrix = system.matrix;
  result.resize(p.size());
  for (size_t i = 0; i < region.vertices.size(); ++i) {
    const int row = region.vertices[i];
    const double* value = matrix.values.data() + 9 * matrix.row_start[row];
    double s0 = 0, s1 = 0, s2 = 0;
    for (int k = matrix.row_start[row]; k < matrix.row_start[row + 1]; ++k, value += 9) {
      const int j = region.place[matrix.column[k]];
      if (j < 0) continue;
      const double* q = p.data() + 3 * j;
      s0 += value[0] * q[0] + value[1] * q[1] + value[2] * q[2];
      s1 += value[3] * q[0] + value[4] * q[1] + value[5] * q[2];
      s2 += value[6] * q[0] + value[7] * q[1] + value[8] * q[2];
    }
    result[3 * i] = s0;
    result[3 * i + 1] = s1;
    result[3 * i + 2] = s2;
  }
  for (const ActiveBarrier& barrier : system.barriers) {
    const std::array<int, 4> place = places(system, barrier);
    PairPoints local = PairPoints::Zero();
    for (int k = 0; k < 4; ++k)
      if (place[k] >= 0) local.col(k) = p.segment<3>(3 * place[k]);
    const PairPoints product = hessian_product(barrier.term, local);
    for (int k = 0; k < 4; ++k)
      if (place[k] >= 0) result.segment<3>(3 * place[k]) += product.col(k);
  }
  if (system.cloth.is_pinned.empty()) return;
  for (size_t i = 0; i < region.vertices.size(); ++i)
    if (system.cloth.is_pinned[region.vertices[i]]) result.segment<3>(3 * i) = p.segment<3>(3 * i);
}

BlockMatrix with_barriers(const NewtonSystem& system) {
  const BlockMatrix& matrix = system.matrix;
  const int count = matrix.rows();
  std::vector<std::pair<int, int>> coupled;
  for (const ActiveBarrier& barrier : system.barriers)
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < a; ++b) {
        const auto [low, high] = std::minmax(barrier.element.vertices[a], barrier.element.vertices[b]);
        if (high < count && !matrix.has(low, high)) coupled.emplace_back(low, high);
      }
  BlockMatrix result;
  if (coupled.empty()) {
    result = matrix;
  } else {
    for (int row = 0; row < count; ++row)
      for (int k = matrix.row_start[row]; k < matrix.row_start[row + 1]; ++k)
        if (matrix.column[k] > row) coupled.emplace_back(row, matrix.column[k]);
    result = make_pattern(count, coupled);
    for (int row = 0; row < count; ++row)
      for (int k = matrix.row_start[row]; k < matrix.row_start[row + 1]; ++k)
        result.block(result.find(row, matrix.column[k])) = matrix.block(k);
  }
  for (const ActiveBarrier& barrier : system.barriers)
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) {
        const int v = barrier.element.vertices[a], w = barrier.element.vertices[b];
        if (v < count && w < count) result.block(result.find(v, w)) += hessian_block(barrier.term, a, b);
      }
  return result;
}

std::vector<Mat<3>> inverse_blocks(const NewtonSystem& system) {
  const std::vector<int>& vertices = system.region.vertices;
  std::vector<Mat<3>> blocks(vertices.size());
  for (size_t i = 0; i < vertices.size(); ++i)
    blocks[i] = system.matrix.block(system.matrix.diagonal[vertices[i]]);
  for (const ActiveBarrier& barrier : system.barriers) {
    const std::array<int, 4> place = places(system, barrier);
    for (int k = 0; k < 4; ++k)
      if (place[k] >= 0) blocks[place[k]] += hessian_block(barrier.term, k, k);
  }
  for (Mat<3>& block : blocks) {
    Eigen::SelfAdjointEigenSolver<Mat<3>> eigen;
    eigen.computeDirect(block);
    const Vec<3> values = eigen.eigenvalues().cwiseAbs();
    const double least = std::max(1e-3 * values.maxCoeff(), 1e-12);
    block = eigen.eigenvectors() * values.cwiseMax(least).cwiseInverse().asDiagonal() *
            eigen.eigenvectors().transpose();
  }
  return blocks;
}

Eigen::VectorXd restrict_to(const Region& region, const Eigen::VectorXd& whole) {
  Eigen::VectorXd part(3 * region.vertices.size());
  for (size_t i = 0; i < region.vertices.size(); ++i)
    part.segment<3>(3 * i) = whole.segment<3>(3 * region.vertices[i]);
  return part;
}

void spread(const Region& region, const Eigen::VectorXd& part, Eigen::VectorXd& whole) {
  for (size_t i = 0; i < region.vertices.size(); ++i)
    whole.segment<3>(3 * region.vertices[i]) = part.segment<3>(3 * i);
}

}  // namespace pleat::sim
