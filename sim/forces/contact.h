// Contact of a cloth vertex with the body, as a one-sided spring on the gap to a tangent plane of
// the body.
//   g = n . (x - q),  u = d - g > 0,  E'' = k min(u/d, 1):  cubic at first touch, quadratic below
//   the surface
// The plane (q, n) is that of the closest body point, n blended from vertex normals, and stays
// fixed within an iteration of the solver: with the mesh's own facetted distance Newton's method
// cycles.
#pragma once

#include "sim/forces/local_energy.h"

namespace pleat::sim {

struct Contact {
  int vertex;
  int body_face;
  Vec<3> barycentric;  // of q on body_face
  Vec<3> point;        // q, m, world
  Vec<3> normal;       // n, outward, unit
  double distance;     // d, m: gap at which the spring starts
  double stiffness;    // k, N/m
};

LocalEnergy<3> contact_energy(const Contact& contact, const Vec<3>& x, Order order);

// Normal force, N, >= 0.
double normal_force(const Contact& contact, const Vec<3>& x);

}  // namespace pleat::sim
