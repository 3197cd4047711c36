#include "sim/drape.h"

namespace pleat::sim {
namespace {

// |gradient| / |weight| on planes asked for anew. Cloth caught where the body overlaps itself is
// left out: both sides push it, and no place is right.
double fresh_residual(const Cloth& cloth, const BodyCollider& collider, const Touching& touching,
                      const Eigen::VectorXd& x) {
  System system;
  assemble(cloth, touching, x, Order::kGradient, system);
  for (const Contact& contact : touching.contacts)
    if (collider.is_near_overlap()[contact.body_face])
      system.gradient.segment<3>(3 * contact.vertex).setZero();
  return system.gradient.norm() / cloth.total_weight;
}

}  // namespace

NewtonResult drape(const Cloth& cloth, const BodyCollider& collider, double friction,
                   const ContactConfig& contact, const NewtonConfig& solver, Cholesky& factor,
                   DrapeState& state) {
  // Planes that stayed with their vertices are asked for anew, and the drape goes on from there.
  constexpr int kPasses = 3;
  NewtonResult total;
  Touching touching;
  for (int pass = 0; pass < kPasses && !total.has_converged; ++pass) {
    NewtonConfig rest = solver;
    rest.max_iterations = solver.max_iterations - total.iterations;
    if (rest.max_iterations < 1) break;
    ContactSearch search(cloth, collider, contact, friction, solver.max_step_m);
    const NewtonResult result = minimise(
        cloth, [&](const Eigen::VectorXd& x) { return search.find(x, state.anchors); }, rest,
        factor, state.x);
    total.iterations += result.iterations;
    total.factorisations += result.factorisations;
    touching = ContactSearch(cloth, collider, contact, friction, solver.max_step_m)
                   .find(state.x, state.anchors);
    total.residual = fresh_residual(cloth, collider, touching, state.x);
    total.has_converged = total.residual <= solver.residual;
  }
  settle_anchors(collider, touching, state.x, contact, state.anchors);
  return total;
}

}  // namespace pleat::sim
