#include "sim/drape.h"

namespace pleat::sim {

NewtonResult drape(const Cloth& cloth, const BodyCollider& collider, double friction,
                   const ContactConfig& contact, const NewtonConfig& solver, Cholesky& factor,
                   DrapeState& state) {
  ContactSearch search(cloth, collider, contact, friction, solver.max_step_m);
  const auto find_touching = [&](const Eigen::VectorXd& x) {
    return search.find(x, state.anchors);
  };
  NewtonResult result = minimise(cloth, find_touching, solver, factor, state.x);
  // The residual that counts is that of planes asked for anew, not of those that stayed.
  ContactSearch anew(cloth, collider, contact, friction, solver.max_step_m);
  const Touching touching = anew.find(state.x, state.anchors);
  System system;
  assemble(cloth, touching, state.x, Order::kGradient, system);
  result.residual = system.gradient.norm() / cloth.total_weight;
  result.has_converged = result.residual <= 2 * solver.residual;
  settle_anchors(collider, touching, state.x, contact, state.anchors);
  return result;
}

}  // namespace pleat::sim
