// Distance of two features of triangle meshes, corner and face or edge and edge, as the minimum over
// where on them it is measured:
//   D = min |r|^2,   r = sum_i w_i x_i,   w affine in the parameters that are free
// With this form one formula gives the derivatives in all cases (docs/derivations/barrier.md).
#pragma once

#include <array>

#include "core/types.h"

namespace pleat::sim {

enum class PairKind : char { kPointFace, kEdgeEdge };

// Four points as columns, m. kPointFace: the point, then the face. kEdgeEdge: one edge, then the
// other.
using PairPoints = Eigen::Matrix<double, 3, 4>;

struct PairDistance {
  Vec<3> difference;  // r, m
  double squared = 0; // D, m^2
  Vec<4> weights;     // w; sum to 0, and to 1 over the first feature
  // Columns: how the weights change along each parameter that the minimum may still move in: 2 in
  // the inside of a face or of both edges, 1 on an edge of the face or at the end of one edge, else 0.
  Eigen::Matrix<double, 4, 2> directions;
  int free = 0;
};

PairDistance pair_distance(PairKind kind, const PairPoints& x);

// The same without its derivatives' ingredients: D only.
double squared_pair_distance(PairKind kind, const PairPoints& x);

// sin^2 of the angle between two edges, 0 parallel .. 1.
double squared_sine_of_edges(const PairPoints& x);

}  // namespace pleat::sim
