// Membrane: stretch and shear of a triangle against its flat rest shape.
//   F = [x1-x0, x2-x0] D^-1 (3 x 2),  G = (F^T F - I)/2,  E = A W(G)
// W is the law of the fabric, sim/forces/membrane_law.h. Bonet and Wood 2008, section 6; worked out
// in docs/derivations/membrane.md.
#pragma once

#include <array>

#include "sim/forces/local_energy.h"
#include "sim/forces/membrane_law.h"

namespace pleat::sim {

struct Membrane {
  std::array<int, 3> vertices;
  Mat<2>
      inverse_rest;  // D^-1, 1/m; D holds the two rest edges from vertex 0 as columns, panel plane
  double area;       // m^2, at rest
};

Membrane make_membrane(const std::array<int, 3>& vertices, const std::array<Vec<2>, 3>& rest);

// x: the three points stacked, m, world.
LocalEnergy<9> membrane_energy(const Membrane& membrane, const MembraneLaw& law, const Vec<9>& x,
                               Order order);

}  // namespace pleat::sim
