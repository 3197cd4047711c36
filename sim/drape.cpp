#include "sim/drape.h"

namespace pleat::sim {

NewtonResult drape(const Cloth& cloth, ContactSearch& contacts, const NewtonConfig& solver,
                   Cholesky& factor, DrapeState& state) {
  const NewtonResult result =
      minimise(cloth, contacts, solver, factor, state.x, state.anchors);
  contacts.settle_anchors(state.x, state.anchors);
  return result;
}

}  // namespace pleat::sim
