// One static equilibrium of a cloth on a body that stands still, from a warm start.
#pragma once

#include <vector>

#include "sim/solver/contacts.h"
#include "sim/solver/newton.h"

namespace pleat::sim {

// What one drape hands to the next.
struct DrapeState {
  Eigen::VectorXd x;            // 3#V, m, world
  std::vector<Anchor> anchors;  // #V
};

// Settles `state` on the body. Not converging is a result, not an error.
NewtonResult drape(const Cloth& cloth, ContactSearch& contacts, const NewtonConfig& solver,
                   Cholesky& factor, DrapeState& state,
                   const std::function<bool()>& should_stop = {});

}  // namespace pleat::sim
