// Membrane: stretch and shear of a triangle against its flat rest shape; isotropic St.
// Venant-Kirchhoff in plane stress.
//   F = [x1-x0, x2-x0] D^-1 (3 x 2),  G = (F^T F - I)/2,  E = A (lambda/2 tr(G)^2 + mu G:G)
//   lambda = Y nu / (1 - nu^2),  mu = Y / (2 (1 + nu)),  Y: Young's modulus times thickness, N/m
// Bonet and Wood 2008, section 6; worked out in docs/derivations/membrane.md.
#pragma once

#include <array>

#include "sim/forces/local_energy.h"

namespace pleat::sim {

struct Membrane {
  std::array<int, 3> vertices;
  Mat<2>
      inverse_rest;   // D^-1, 1/m; D holds the two rest edges from vertex 0 as columns, panel plane
  double area;        // m^2, at rest
  double lambda, mu;  // N/m
};

Membrane make_membrane(const std::array<int, 3>& vertices, const std::array<Vec<2>, 3>& rest,
                       double youngs_modulus, double poisson_ratio);

// x: the three points stacked, m, world.
LocalEnergy<9> membrane_energy(const Membrane& membrane, const Vec<9>& x, Order order);

}  // namespace pleat::sim
