// Static equilibrium: a minimum of the total energy, by damped Newton steps (Levenberg 1944).
//
// Far from it, on the Hessian clamped to be positive semi-definite: cloth that buckles has many
// directions of negative curvature, and with the exact Hessian they would allow tiny steps only.
// Near it, on the exact one, where that is positive definite: quadratic convergence. The damping is
// a mass over a time squared, so that a step looks like one of implicit dynamics without velocity,
// and adapts to how well the model foretells the energy.
#pragma once

#include <functional>

#include "sim/solver/assemble.h"
#include "sim/solver/cholesky.h"

namespace pleat::sim {

struct NewtonConfig {      // section `solver`
  double residual = 1e-3;  // stop at |gradient| <= residual * |weight of the cloth|
  int max_iterations = 300;
  double max_step_m = 0.01;      // no vertex moves farther in one iteration
  double near_residual = 0.005;  // below it, the exact Hessian is tried
};
void validate(const NewtonConfig& config);

struct NewtonResult {
  bool has_converged = false;
  double residual = 0;  // |gradient| / |weight|
  int iterations = 0;
  int factorisations = 0;
};

// x: 3#V, in and out. find_touching is asked before each iteration. `factor` keeps its analysis
// between calls.
NewtonResult minimise(const Cloth& cloth,
                      const std::function<Touching(const Eigen::VectorXd&)>& find_touching,
                      const NewtonConfig& config, Cholesky& factor, Eigen::VectorXd& x);

}  // namespace pleat::sim
