// Static equilibrium: a minimum of the total energy, by Newton's method within a trust region, on
// steps that never pass through anything.
//
// Buckling makes most of the work: while a fold snaps to another side, a few dozen vertices keep
// the whole cloth from converging. So between steps of the whole the worst of it is settled by
// itself, the rest standing still: nonlinear elimination, Cai and Li 2011, "Inexact Newton Methods
// with Restricted Additive Schwarz Based Nonlinear Elimination". docs/solver.md.
#pragma once

#include <functional>

#include "sim/solver/assemble.h"
#include "sim/solver/cholesky.h"
#include "sim/solver/contacts.h"

namespace pleat::sim {

struct NewtonConfig {        // section `solver`
  double residual = 1e-3;    // stop at |gradient| <= residual * |weights|, norms over all vertices
  int max_iterations = 200;  // of the whole cloth
  double max_step_m = 0.01;  // no vertex moves farther in one iteration
  bool must_be_stable = true;  // go on from where the Hessian is not positive definite
};
void validate(const NewtonConfig& config);

struct NewtonResult {
  bool has_converged = false;  // to the residual asked for, and to where it is stable if it must be
  bool is_stable = false;      // the Hessian at the end is positive definite
  double residual = 0;         // |gradient| / |weights|
  int iterations = 0;          // of the whole cloth
  int local_iterations = 0;    // of its worst parts
  int products = 0;            // with the Hessian of the whole cloth
  int factorisations = 0;
};

// x: 3#V, in and out, free of intersections before and after. `factor` is kept between calls.
// should_stop is asked before each iteration.
NewtonResult minimise(const Cloth& cloth, ContactSearch& contacts, const NewtonConfig& config,
                      Cholesky& factor, Eigen::VectorXd& x, std::vector<Anchor>& anchors,
                      const std::function<bool()>& should_stop = {});

}  // namespace pleat::sim
