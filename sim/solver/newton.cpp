#include "sim/solver/newton.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace pleat::sim {
namespace {

constexpr double kAcceptRatio = 1e-4;  // of the energy's drop to the model's
constexpr double kLeastDamping =
    30;  // 1/s^2: a step is at least as cautious as a dynamic one of 0.18 s
constexpr double kMostDamping = 1e12;  // no step is found there any more
constexpr double kDampingFactor = 4;

double largest_move(const Eigen::VectorXd& step) {
  double largest = 0;
  for (Eigen::Index v = 0; v < step.size() / 3; ++v)
    largest = std::max(largest, step.segment<3>(3 * v).norm());
  return largest;
}

struct Step {
  Eigen::VectorXd p;
  double model_drop = 0;  // of the energy, as its quadratic model tells
};

Step solve_step(const Cholesky& factor, const BlockMatrix& hessian, const Eigen::VectorXd& gradient,
                double max_step) {
  Step step;
  step.p = -factor.solve(gradient);
  const double move = largest_move(step.p);
  if (move > max_step) step.p *= max_step / move;
  Eigen::VectorXd Hp;
  multiply(hessian, step.p, Hp);
  step.model_drop = -step.p.dot(gradient) - 0.5 * step.p.dot(Hp);
  return step;
}

}  // namespace

void validate(const NewtonConfig& config) {
  if (!(config.residual > 0 && config.residual < 1))
    throw InputError("solver.residual must lie in (0, 1)");
  if (config.max_iterations < 1) throw InputError("solver.max_iterations must be >= 1");
  if (!(config.max_step_m > 0)) throw InputError("solver.max_step_m must be > 0");
  if (!(config.near_residual >= 0)) throw InputError("solver.near_residual must be >= 0");
}

NewtonResult minimise(const Cloth& cloth,
                      const std::function<Touching(const Eigen::VectorXd&)>& find_touching,
                      const NewtonConfig& config, Cholesky& factor, Eigen::VectorXd& x) {
  Eigen::VectorXd mass(cloth.vertex_count);
  for (const Weight& weight : cloth.weights) mass[weight.vertex] = weight.mass;
  NewtonResult result;
  System system, trial;
  double damping = kLeastDamping;
  Touching touching = find_touching(x);
  while (true) {
    assemble(cloth, touching, x, Order::kProjectedHessian, system);
    result.residual = system.gradient.norm() / cloth.total_weight;
    result.has_converged = result.residual <= config.residual;
    if (result.has_converged || !(result.iterations < config.max_iterations) ||
        !(damping < kMostDamping))
      return result;
    if (result.residual <= config.near_residual) {
      assemble(cloth, touching, x, Order::kHessian, system);
      ++result.factorisations;
      if (!factor.factor(system.hessian, damping * mass))
        assemble(cloth, touching, x, Order::kProjectedHessian, system);
    }
    for (bool is_accepted = false; !is_accepted && damping < kMostDamping;) {
      ++result.factorisations;
      if (factor.factor(system.hessian, damping * mass)) {
        const Step step = solve_step(factor, system.hessian, system.gradient, config.max_step_m);
        const Eigen::VectorXd x_trial = x + step.p;
        assemble(cloth, touching, x_trial, Order::kValue, trial);
        const double ratio = (system.energy - trial.energy) / step.model_drop;
        is_accepted = ratio > kAcceptRatio;
        if (is_accepted) x = x_trial;
        if (ratio > 0.75) damping = std::max(kLeastDamping, damping / kDampingFactor);
        if (ratio >= 0.25) continue;
      }
      damping = std::max(16 * kLeastDamping, kDampingFactor * damping);
    }
    ++result.iterations;
    touching = find_touching(x);
  }
}

}  // namespace pleat::sim
