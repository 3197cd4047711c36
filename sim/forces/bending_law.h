// Laws of bending: the energy of a unit of rest area as a function of the curvature c >= 0 across
// an edge, known by its magnitude only.
//
// constant   w = B/2 c^2
// measured   w = integral of the moment M over c; M runs through the table's B c at c = 0, 10, 20,
//            30, 40 1/m, never falls, and goes on with the last B. One curve a fold direction of 0,
//            45 and 90 degrees from panel axis 0; an edge mixes them by its own direction.
// Worked out in docs/derivations/bending.md.
#pragma once

#include <array>

#include "core/types.h"
#include "garment/fabric.h"

namespace pleat::sim {

struct BendingLaw {
  static constexpr int kPieces = 5;  // four between the table's curvatures, one beyond
  double rigidity = 0;               // B, N m; of the constant law
  bool is_measured = false;
  // Of each direction and piece, from its start: w, then M = m + u (p + u (q + u r)).
  std::array<std::array<Vec<5>, kPieces>, 3> curves{};
};

BendingLaw make_bending_law(const garment::Fabric& fabric);

// weights: of the three directions. Of a measured law.
struct BendingResponse {
  double energy;            // w, J/m^2
  double secant_rigidity;   // M/c, N m; its limit at c = 0
  double tangent_rigidity;  // dM/dc >= 0, N m
};
BendingResponse measured_bending(const BendingLaw& law, const Vec<3>& weights, double curvature);

}  // namespace pleat::sim
