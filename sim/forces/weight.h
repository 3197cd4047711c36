// Weight of the mass lumped at a vertex.        E = m g y,  y up
#pragma once

#include "sim/forces/local_energy.h"

namespace pleat::sim {

constexpr double kGravity = 9.80665;  // m/s^2, standard

struct Weight {
  int vertex;
  double mass;  // kg
};

inline LocalEnergy<3> weight_energy(const Weight& weight, const Vec<3>& x, Order order) {
  LocalEnergy<3> energy;
  energy.value = weight.mass * kGravity * x.y();
  if (order >= Order::kGradient) energy.gradient << 0, weight.mass * kGravity, 0;
  if (order >= Order::kProjectedHessian) energy.hessian.setZero();
  return energy;
}

}  // namespace pleat::sim
