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

}  // namespace

Bending make_bending(const std::array<int, 4>& vertices, const std::array<Vec<2>, 3>& rest_0,
                     const std::array<Vec<2>, 3>& rest_1, double flexural_rigidity) {
  const double start_0 = cotangent(rest_0[0], rest_0[1], rest_0[2]);
  const double end_0 = cotangent(rest_0[1], rest_0[0], rest_0[2]);
  const double start_1 = cotangent(rest_1[0], rest_1[1], rest_1[2]);
  const double end_1 = cotangent(rest_1[1], rest_1[0], rest_1[2]);
  const double area = 0.5 * std::abs(cross(rest_0[1] - rest_0[0], rest_0[2] - rest_0[0])) +
                      0.5 * std::abs(cross(rest_1[1] - rest_1[0], rest_1[2] - rest_1[0]));
  Bending bending;
  bending.vertices = vertices;
  bending.stencil << end_0 + end_1, start_0 + start_1, -(start_0 + end_0), -(start_1 + end_1);
  bending.stiffness = flexural_rigidity / area;
  return bending;
}

LocalEnergy<12> bending_energy(const Bending& bending, const Vec<12>& x, Order order) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 4>> points(x.data());
  const Vec<3> laplacian = points * bending.stencil;
  LocalEnergy<12> energy;
  energy.value = 0.5 * bending.stiffness * laplacian.squaredNorm();
  if (order < Order::kGradient) return energy;
  Eigen::Map<Eigen::Matrix<double, 3, 4>>(energy.gradient.data()) =
      bending.stiffness * laplacian * bending.stencil.transpose();
  if (order < Order::kProjectedHessian) return energy;
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b)
      for (int c = 0; c < 3; ++c)
        energy.hessian(3 * a + c, 3 * b + c) =
            bending.stiffness * bending.stencil[a] * bending.stencil[b];
  return energy;
}

}  // namespace pleat::sim
