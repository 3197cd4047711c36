// Bending across an inner edge, for sheets that bend far more easily than they stretch.
//   E = B/2 * |sum_i k_i x_i|^2 / (A_0 + A_1),  k: cotangents of the rest angles
// The sum is the edge's length times the jump of the normal, so curvature enters by magnitude only.
// Quadratic in x, with a constant and positive semi-definite Hessian: Bergou et al. 2006, "A
// Quadratic Bending Model for Inextensible Surfaces". Their factor 3 is left out: on an equilateral
// lattice the energy above is that of the plate in every direction (Seung and Nelson 1988,
// equation 2.5 with 2 B / sqrt(3)); worked out in docs/derivations/bending.md.
#pragma once

#include <array>

#include "sim/forces/local_energy.h"

namespace pleat::sim {

struct Bending {
  std::array<int, 4> vertices;  // the edge's two ends, then the corner opposite in each face
  Vec<4> stencil;               // k, dimensionless
  double stiffness;             // B / (A_0 + A_1), J/m^2
};

// rest_0: edge ends and opposite corner of the first face in its panel's plane, rest_1: of the
// second in its own.
Bending make_bending(const std::array<int, 4>& vertices, const std::array<Vec<2>, 3>& rest_0,
                     const std::array<Vec<2>, 3>& rest_1, double flexural_rigidity);

// x: the four points stacked, m, world.
LocalEnergy<12> bending_energy(const Bending& bending, const Vec<12>& x, Order order);

}  // namespace pleat::sim
