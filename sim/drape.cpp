#include "sim/drape.h"

namespace pleat::sim {

NewtonResult drape(const Cloth& cloth, ContactSearch& contacts, const NewtonConfig& solver,
                   Cholesky& factor, DrapeState& state, const std::function<bool()>& should_stop) {
  const NewtonResult result =
      minimise(cloth, contacts, solver, factor, state.x, state.anchors, should_stop);
  contacts.settle_anchors(state.x, state.anchors);
  return result;
}

}  // namespace pleat::sim
