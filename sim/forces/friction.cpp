#include "sim/forces/friction.h"

namespace pleat::sim {

LocalEnergy<3> friction_energy(const Friction& friction, const Vec<3>& x, Order order) {
  const Mat<3> tangential = Mat<3>::Identity() - friction.normal * friction.normal.transpose();
  const Vec<3> u = tangential * (x - friction.anchor);
  const double s = u.norm(), k = friction.stiffness;
  const bool sticks = k * s <= friction.limit;
  LocalEnergy<3> energy;
  energy.value = sticks ? 0.5 * k * s * s : friction.limit * (s - 0.5 * friction.limit / k);
  if (order < Order::kGradient) return energy;
  const double secant = sticks ? k : friction.limit / s;
  energy.gradient = secant * u;
  if (order < Order::kProjectedHessian) return energy;
  energy.hessian = secant * tangential;
  if (!sticks) energy.hessian -= secant / (s * s) * u * u.transpose();
  return energy;
}

}  // namespace pleat::sim
