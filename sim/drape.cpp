#include "sim/drape.h"

namespace pleat::sim {

NewtonResult drape(const Cloth& cloth, const BodyCollider& collider, double friction,
                   const ContactConfig& contact, const NewtonConfig& solver, Cholesky& factor,
                   DrapeState& state) {
  ContactSearch search(cloth, collider, contact, friction, solver.max_step_m);
  const auto find_touching = [&](const Eigen::VectorXd& x) {
    return search.find(x, state.anchors);
  };
  const NewtonResult result = minimise(cloth, find_touching, solver, factor, state.x);
  settle_anchors(collider, search.find(state.x, state.anchors), state.x, contact, state.anchors);
  return result;
}

}  // namespace pleat::sim
