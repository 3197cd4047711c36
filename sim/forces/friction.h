// Dry friction of a cloth vertex on the body, as a potential of the slip from the body point it
// sticks to.
//   u = (I - n n^T)(x - a),  s = |u|,  E = k s^2/2 while k s < mu N, beyond it mu N (s - mu N / (2 k))
// The vertex sticks to a by a spring, and slides against the force mu N where that would pull harder
// (Coulomb's law as elastic, perfectly plastic slip). N is held fixed within an iteration of the
// solver; a vertex that sticks does not feel it.
#pragma once

#include "sim/forces/local_energy.h"

namespace pleat::sim {

struct Friction {
  int vertex;
  Vec<3> anchor;  // a, m, world
  Vec<3> normal;  // n, unit
  double limit;   // mu N, N
  double stiffness;  // k, N/m
};

LocalEnergy<3> friction_energy(const Friction& friction, const Vec<3>& x, Order order);

}  // namespace pleat::sim
