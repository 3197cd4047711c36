// Barrier between two features of meshes that must not pass through one another, corner and face or
// edge and edge, cloth against cloth or cloth against body.
//   E = k d_hat B(d / d_hat),   B(u) = -(1 - u)^2 ln u  for u < 1, else 0
// d: distance of the two features. Smooth where it begins (twice differentiable), unbounded at d = 0.
// Between edges that are nearly parallel, whose closest points jump, E is faded out:
//   E m(c / c_0),   c = |a x b|^2,   m(t) = t (2 - t)  for t < 1, else 1
// Both functions are those of Li et al. 2020, "Incremental Potential Contact", sections 4 and 5.2, B on
// d instead of d^2; worked out in docs/derivations/barrier.md.
#pragma once

#include <array>
#include <memory>

#include "sim/forces/local_energy.h"
#include "sim/solver/pair_distance.h"

namespace pleat::sim {

struct Barrier {
  std::array<int, 4> vertices;  // cloth, or behind the cloth's those of the body
  PairKind kind;
  double distance;   // d_hat, m
  double stiffness;  // k, N: a pressure times the area that the pair stands for
  double parallel;   // c_0, m^4, > 0; of two edges
};

// x: the four points stacked, m, world.
LocalEnergy<12> barrier_energy(const Barrier& barrier, const Vec<12>& x, Order order);

// The same in factors, for thousands of pairs: what a product with the Hessian needs.
struct BarrierTerm {
  double value = 0;  // J
  double slope = 0;  // dE/dd, N, negative
  double radial = 0;     // second derivative along r, N/m
  double rotational = 0;  // times the Hessian of D without its radial part, N/m: negative; 0 in a projected Hessian
  Vec<3> unit = Vec<3>::Zero();  // r / d
  PairDistance place;
  Vec<3> across[2] = {Vec<3>::Zero(), Vec<3>::Zero()};  // change of r along each free parameter
  Mat<2> inverse = Mat<2>::Zero();  // of the matrix of their products
  // Of a pair that is faded out, which has no such factors: the derivatives themselves.
  struct Faded {
    PairPoints gradient;
    Mat<12> hessian;
  };
  std::shared_ptr<const Faded> faded;
};

// Only for d < d_hat. Orders as everywhere: kValue fills `value` only.
BarrierTerm barrier_term(const Barrier& barrier, const PairPoints& x, Order order);

inline Vec<3> force_gradient(const BarrierTerm& term, int corner) {
  if (term.faded) return term.faded->gradient.col(corner);
  return term.slope * term.place.weights[corner] * term.unit;
}
// Block (a, b) of the Hessian.
Mat<3> hessian_block(const BarrierTerm& term, int a, int b);
// Column a: sum over b of block (a, b) p.col(b).
PairPoints hessian_product(const BarrierTerm& term, const PairPoints& p);

}  // namespace pleat::sim
