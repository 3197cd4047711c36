#include "sim/forces/contact.h"

namespace pleat::sim {
namespace {

// E(u), E'(u), E''(u) of the header.
Vec<3> spring(const Contact& contact, double u) {
  const double d = contact.distance, k = contact.stiffness;
  if (u <= 0) return Vec<3>::Zero();
  if (u < d) return {k * u * u * u / (6 * d), k * u * u / (2 * d), k * u / d};
  const double beyond = u - d;
  return {k * (d * d / 6 + d * beyond / 2 + beyond * beyond / 2), k * (d / 2 + beyond), k};
}

double depth(const Contact& contact, const Vec<3>& x) {
  return contact.distance - contact.normal.dot(x - contact.point);
}

}  // namespace

LocalEnergy<3> contact_energy(const Contact& contact, const Vec<3>& x, Order order) {
  const Vec<3> e = spring(contact, depth(contact, x));
  LocalEnergy<3> energy;
  energy.value = e[0];
  if (order >= Order::kGradient) energy.gradient = -e[1] * contact.normal;
  if (order >= Order::kProjectedHessian)
    energy.hessian = e[2] * contact.normal * contact.normal.transpose();
  return energy;
}

double normal_force(const Contact& contact, const Vec<3>& x) {
  return spring(contact, depth(contact, x))[1];
}

}  // namespace pleat::sim
