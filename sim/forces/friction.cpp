#include "sim/forces/friction.h"

namespace pleat::sim {

LocalEnergy<3> friction_energy(const Friction& friction, const Vec<3>& x, Order order) {
  const Mat<3> tangential = Mat<3>::Identity() - friction.normal * friction.normal.transpose();
  const Vec<3> u = tangential * (x - friction.anchor);
  const double s = u.norm(), eps = friction.slip;
  const bool sticks = s < eps;
  LocalEnergy<3> energy;
  energy.value = friction.limit * (sticks ? s * s / (2 * eps) : s - eps / 2);
  if (order < Order::kGradient) return energy;
  const double stiffness = friction.limit / (sticks ? eps : s);
  energy.gradient = stiffness * u;
  if (order < Order::kProjectedHessian) return energy;
  energy.hessian = stiffness * tangential;
  if (!sticks) energy.hessian -= stiffness / (s * s) * u * u.transpose();
  return energy;
}

}  // namespace pleat::sim
