// Bending across an inner edge, for sheets that bend far more easily than they stretch.
//   y = sum_i k_i x_i,  E = A w(|y| / A),  A = A_0 + A_1,  k: cotangents of the rest angles
// y is the edge's length times the jump of the normal, so curvature enters by magnitude only; w is
// the law of the fabric, sim/forces/bending_law.h. With constant rigidity E is quadratic in x, with
// a constant and positive semi-definite Hessian: Bergou et al. 2006, "A Quadratic Bending Model for
// Inextensible Surfaces". Their factor 3 is left out: on an equilateral lattice the energy above is
// that of the plate in every direction (Seung and Nelson 1988, equation 2.5 with 2 B / sqrt(3));
// worked out in docs/derivations/bending.md.
#pragma once

#include <array>

#include "sim/forces/bending_law.h"
#include "sim/forces/local_energy.h"

namespace pleat::sim {

struct Bending {
  std::array<int, 4> vertices;  // the edge's two ends, then the corner opposite in each face
  Vec<4> stencil;               // k, dimensionless
  double area;                  // A, m^2
  Vec<3> directions;            // weights of a fold at 0, 45 and 90 degrees from panel axis 0
};

// rest_0: edge ends and opposite corner of the first face in its panel's plane, rest_1: of the
// second in its own. Each side weighs by its area.
Bending make_bending(const std::array<int, 4>& vertices, const std::array<Vec<2>, 3>& rest_0,
                     const std::array<Vec<2>, 3>& rest_1);

// y of the four points, m.
inline Vec<3> normal_jump(const Bending& bending, const Vec<12>& x) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 4>>(x.data()) * bending.stencil;
}

// As a function of y: the gradient at corner i is k_i times this one's, Hessian block (i, j) k_i
// k_j times. Convex, so that nothing needs projection.
LocalEnergy<3> jump_energy(const Bending& bending, const BendingLaw& law, const Vec<3>& y,
                           Order order);

// x: the four points stacked, m, world.
LocalEnergy<12> bending_energy(const Bending& bending, const BendingLaw& law, const Vec<12>& x,
                               Order order);

}  // namespace pleat::sim
