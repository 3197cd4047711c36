// Contact of a cloth vertex with the body, as a one-sided spring on its distance phi to the body's
// smooth surface (BodyCollider::field).
//   u = d - phi(x) > 0,  E'' = k min(u/d, 1):  cubic at first touch, quadratic below the surface
// docs/derivations/contact.md.
#pragma once

#include <limits>

#include "sim/body_contact.h"
#include "sim/forces/local_energy.h"

namespace pleat::sim {

struct Contact {
  int vertex;
  int body_face;       // the nearest
  Vec<3> barycentric;  // of the nearest point
  Vec<3> normal;       // of the body there
  double distance;     // d, m: where the spring starts
  double stiffness;    // k, N/m
  Vec<3> seen_at;      // m, world: where the vertex stood when it was found, and
  double room;         // m, how far it may go from there without touching
  bool is_flat;        // phi is the distance to the plane through the nearest point, not the field
  BodyField known = {};  // phi and its derivatives where the vertex stood last,
  Vec<3> known_at = Vec<3>::Constant(std::numeric_limits<double>::quiet_NaN());
};

// Whether a vertex at x is too far off to touch.
inline bool is_clear(const Contact& contact, const Vec<3>& x) {
  return contact.room > 0 && (x - contact.seen_at).squaredNorm() < contact.room * contact.room;
}

// phi and its derivatives as the contact sees them.
BodyField contact_field(const Contact& contact, const BodyCollider& body, const Vec<3>& x,
                        int order);

LocalEnergy<3> contact_energy(const Contact& contact, const BodyCollider& body, const Vec<3>& x,
                              Order order);

// -dE/dphi, N, >= 0.
double normal_force(const Contact& contact, double phi);

}  // namespace pleat::sim
