#include "sim/forces/bending.h"

#include <cmath>

namespace pleat::sim {
namespace {

double cross(const Vec<2>& a, const Vec<2>& b) { return a.x() * b.y() - a.y() * b.x(); }

// Cotangent of the angle at `corner` between the directions to a and b.
double cotangent(const Vec<2>& corner, const Vec<2>& a, const Vec<2>& b) {
  const Vec<2> u = a - corner, v = b - corner;
  return u.dot(v) / std::abs(cross(u, v));
}

double face_area(const std::array<Vec<2>, 3>& rest) {
  return 0.5 * std::abs(cross(rest[1] - rest[0], rest[2] - rest[0]));
}

// How much a fold along `edge` is one at 0, 45 and 90 degrees: linear in between, and the same for
// the four quadrants.
Vec<3> direction_weights(const Vec<2>& edge) {
  const double steps = std::atan2(std::abs(edge.y()), std::abs(edge.x())) / (M_PI / 4);  // 0 .. 2
  return {std::max(0.0, 1 - steps), 1 - std::abs(1 - steps), std::max(0.0, steps - 1)};
}

}  // namespace

Bending make_bending(const std::array<int, 4>& vertices, const std::array<Vec<2>, 3>& rest_0,
                     const std::array<Vec<2>, 3>& rest_1) {
  const double start_0 = cotangent(rest_0[0], rest_0[1], rest_0[2]);
  const double end_0 = cotangent(rest_0[1], rest_0[0], rest_0[2]);
  const double start_1 = cotangent(rest_1[0], rest_1[1], rest_1[2]);
  const double end_1 = cotangent(rest_1[1], rest_1[0], rest_1[2]);
  const double area_0 = face_area(rest_0), area_1 = face_area(rest_1);
  Bending bending;
  bending.vertices = vertices;
  bending.stencil << end_0 + end_1, start_0 + start_1, -(start_0 + end_0), -(start_1 + end_1);
  bending.area = area_0 + area_1;
  bending.directions = (area_0 * direction_weights(rest_0[1] - rest_0[0]) +
                        area_1 * direction_weights(rest_1[1] - rest_1[0])) /
                       bending.area;
  return bending;
}

LocalEnergy<3> jump_energy(const Bending& bending, const BendingLaw& law, const Vec<3>& y,
                           Order order) {
  LocalEnergy<3> energy;
  if (!law.is_measured) {
    const double stiffness = law.rigidity / bending.area;
    energy.value = 0.5 * stiffness * y.squaredNorm();
    if (order >= Order::kGradient) energy.gradient = stiffness * y;
    if (order >= Order::kProjectedHessian) energy.hessian = stiffness * Mat<3>::Identity();
    return energy;
  }
  const BendingResponse w = measured_bending(law, bending.directions, y.norm() / bending.area);
  energy.value = bending.area * w.energy;
  if (order < Order::kGradient) return energy;
  const double across = w.secant_rigidity / bending.area;
  energy.gradient = across * y;
  if (order < Order::kProjectedHessian) return energy;
  energy.hessian = across * Mat<3>::Identity();
  const double squared = y.squaredNorm();
  if (squared > 0)
    energy.hessian += ((w.tangent_rigidity / bending.area - across) / squared) * y * y.transpose();
  return energy;
}

LocalEnergy<12> bending_energy(const Bending& bending, const BendingLaw& law, const Vec<12>& x,
                               Order order) {
  const LocalEnergy<3> jump = jump_energy(bending, law, normal_jump(bending, x), order);
  LocalEnergy<12> energy;
  energy.value = jump.value;
  if (order < Order::kGradient) return energy;
  for (int a = 0; a < 4; ++a)
    energy.gradient.segment<3>(3 * a) = bending.stencil[a] * jump.gradient;
  if (order < Order::kProjectedHessian) return energy;
  energy.hessian.setZero();
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b)
      energy.hessian.block<3, 3>(3 * a, 3 * b) =
          bending.stencil[a] * bending.stencil[b] * jump.hessian;
  return energy;
}

}  // namespace pleat::sim
