// Dry friction of a cloth vertex on the body, as a potential of the slip from the body point it
// sticks to.
//   u = (I - n n^T)(x - a),  E = mu N h(|u|),  h(s) = s^2/(2 eps) below eps, s - eps/2 above
// Below eps the vertex sticks (a stiff spring), above it slides against the force mu N. N is held
// fixed within an iteration of the solver, as in Li et al. 2020, "Incremental Potential Contact",
// section 5.
#pragma once

#include "sim/forces/local_energy.h"

namespace pleat::sim {

struct Friction {
  int vertex;
  Vec<3> anchor;  // a, m, world
  Vec<3> normal;  // n, unit
  double limit;   // mu N, N
  double slip;    // eps, m
};

LocalEnergy<3> friction_energy(const Friction& friction, const Vec<3>& x, Order order);

}  // namespace pleat::sim
