#include "sim/forces/contact.h"

#include <algorithm>

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

}  // namespace

BodyField contact_field(const Contact& contact, const BodyCollider& body, const Vec<3>& x,
                        int order) {
  if (contact.known_at == x) return contact.known;
  if (!contact.is_flat)
    return body.field(contact.body_face, contact.normal, x, contact.distance, order);
  const Vec<3> nearest = body.point(contact.body_face, contact.barycentric);
  return {contact.normal.dot(x - nearest), contact.normal, Mat<3>::Zero()};
}

LocalEnergy<3> contact_energy(const Contact& contact, const BodyCollider& body, const Vec<3>& x,
                              Order order) {
  LocalEnergy<3> energy;
  if (is_clear(contact, x)) {
    energy.value = 0;
    if (order >= Order::kGradient) energy.gradient.setZero();
    if (order >= Order::kProjectedHessian) energy.hessian.setZero();
    return energy;
  }
  const BodyField field = contact_field(contact, body, x, std::min(2, static_cast<int>(order)));
  const Vec<3> e = spring(contact, contact.distance - field.phi);
  energy.value = e[0];
  if (order < Order::kGradient) return energy;
  energy.gradient = -e[1] * field.gradient;
  if (order < Order::kProjectedHessian) return energy;
  energy.hessian = e[2] * field.gradient * field.gradient.transpose();
  if (order == Order::kHessian) energy.hessian -= e[1] * field.hessian;
  return energy;
}

double normal_force(const Contact& contact, double phi) {
  return spring(contact, contact.distance - phi)[1];
}

}  // namespace pleat::sim
