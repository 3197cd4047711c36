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

// A step and how the search along it ended.
struct Search {
  double length = 0;  // of the step taken, in steps; 0: none lowers the energy enough
  double ratio = 0;   // of the energy's drop to the model's, at the full step
};

// Energies cost little beside a factorisation: shorter steps are tried before another damping, and
// longer ones where the clamped Hessian was too cautious.
template <typename Energy>
Search search_along(const Energy& energy, double start, double slope, double curvature,
                    double longest) {
  constexpr double kLeastLength = 1.0 / 16;
  Search search;
  double at = energy(1.0);
  search.ratio = (start - at) / -(slope + 0.5 * curvature);
  double length = 1;
  while (!(at <= start + kAcceptRatio * length * slope)) {
    length /= 2;
    if (length < kLeastLength) return search;
    at = energy(length);
  }
  while (length >= 1 && 2 * length <= longest) {
    const double beyond = energy(2 * length);
    if (!(beyond < at)) break;
    at = beyond;
    length *= 2;
  }
  search.length = length;
  return search;
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
    while (damping < kMostDamping) {
      ++result.factorisations;
      Search search;
      if (factor.factor(system.hessian, damping * mass)) {
        Eigen::VectorXd p = -factor.solve(system.gradient), Hp;
        const double move = largest_move(p);
        if (move > config.max_step_m) p *= config.max_step_m / move;
        multiply(system.hessian, p, Hp);
        const auto energy = [&](double length) {
          assemble(cloth, touching, x + length * p, Order::kValue, trial);
          return trial.energy;
        };
        search = search_along(energy, system.energy, p.dot(system.gradient), p.dot(Hp),
                              config.max_step_m / std::min(move, config.max_step_m));
        x += search.length * p;
      }
      if (search.ratio > 0.75)
        damping = std::max(kLeastDamping, damping / kDampingFactor);
      else if (search.ratio < 0.25)
        damping = std::max(16 * kLeastDamping, kDampingFactor * damping);
      if (search.length > 0) break;
    }
    ++result.iterations;
    touching = find_touching(x);
  }
}

}  // namespace pleat::sim
