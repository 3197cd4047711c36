// Laws of the membrane: the energy of a unit of rest area as a function of its Green strain,
//   g = (G_00, G_11, 2 G_01),  S = dW/dg = (S_00, S_11, S_01),  panel axes 0 (across) and 1 (up)
//
// St. Venant-Kirchhoff    W = lambda/2 tr(G)^2 + mu G:G
// neo-Hookean             W = mu/2 (tr C - 2) - mu ln J + lambda/2 (ln J)^2,  C = 2 G + I, J^2 =
// det C
//   lambda = Y nu / (1 - nu^2),  mu = Y / (2 (1 + nu)),  Y: Young's modulus times thickness, N/m
//   Bonet and Wood 2008, section 6, in plane stress; both are the same for small strains.
// measured                W = Q_0 + s (Q_mean - Q_0 + f (Q_z - Q_mean)),
//                         Q_k(g) = k_uu G_00^2 + 2 k_uv G_00 G_11 + k_vv G_11^2 + 2 k_s G_01^2
//   Tables of stiffness over size (s) and direction (z) of the strain: Wang et al. 2011,
//   "Data-Driven Elastic Models for Cloth", made a stored energy here. f fades the direction out
//   where stretch is alike in all of them.
// Worked out in docs/derivations/membrane.md.
#pragma once

#include <array>

#include "garment/fabric.h"
#include "sim/forces/local_energy.h"

namespace pleat::sim {

struct MembraneLaw {
  enum class Kind { kStVenantKirchhoff, kNeoHookean, kMeasured };
  Kind kind = Kind::kStVenantKirchhoff;
  double lambda = 0, mu = 0;  // N/m; not of kMeasured
  // (k_uu, k_uv, k_vv, k_s), N/m: unstrained, then at the table's strain with the larger stretch at
  // 0, 22.5, 45, 67.5 and 90 degrees from axis 0. Each Q_k is >= 0.
  std::array<Vec<4>, 6> rows{};
  Vec<4> mean = Vec<4>::Zero();  // of rows 1 .. 5 over all directions
};

MembraneLaw make_membrane_law(const garment::Fabric& fabric);

// Fields above the order that was asked for hold nothing.
struct MembraneResponse {
  double energy;   // W, J/m^2
  Vec<3> stress;   // dW/dg, second Piola-Kirchhoff, N/m
  Mat<3> tangent;  // d2W/dg2, N/m; exact
};
MembraneResponse membrane_response(const MembraneLaw& law, const Vec<3>& g, Order order);

}  // namespace pleat::sim
