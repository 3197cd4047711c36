#include "sim/forces/membrane.h"

#include <Eigen/LU>
#include <cmath>

namespace pleat::sim {
namespace {

// The 2 x 2 stress without its negative eigenvalues: (S_00, S_11, S_01).
Vec<3> tensile_part(const Vec<3>& stress) {
  const double mean = 0.5 * (stress[0] + stress[1]), half = 0.5 * (stress[0] - stress[1]);
  const double radius = std::sqrt(half * half + stress[2] * stress[2]);
  const double larger = mean + radius, smaller = mean - radius;
  if (smaller >= 0) return stress;
  if (larger <= 0) return Vec<3>::Zero();
  return larger / (2 * radius) * (stress - Vec<3>(smaller, smaller, 0));
}

// Most tangents are positive definite, as their leading minors tell; the others pay for it.
Mat<3> positive_part(const Mat<3>& tangent) {
  const double minor = tangent(0, 0) * tangent(1, 1) - tangent(0, 1) * tangent(1, 0);
  const bool is_positive = tangent(0, 0) > 0 && minor > 0 && tangent.determinant() > 0;
  return is_positive ? tangent : clamp_to_positive<3>(tangent);
}

}  // namespace

Membrane make_membrane(const std::array<int, 3>& vertices, const std::array<Vec<2>, 3>& rest) {
  Mat<2> edges;
  edges << rest[1] - rest[0], rest[2] - rest[0];
  return {vertices, edges.inverse(), 0.5 * std::abs(edges.determinant())};
}

LocalEnergy<9> membrane_energy(const Membrane& membrane, const MembraneLaw& law, const Vec<9>& x,
                               Order order) {
  // Rows 0 and 1 of D^-1 are the gradients of the hat functions of corners 1 and 2; that of corner
  // 0 is minus their sum, and so are its derivatives.
  const Mat<2>& shape = membrane.inverse_rest;
  const double area = membrane.area;
  const Vec<3> edge_1 = x.segment<3>(3) - x.head<3>(), edge_2 = x.tail<3>() - x.head<3>();
  const Vec<3> f0 = shape(0, 0) * edge_1 + shape(1, 0) * edge_2;  // columns of F
  const Vec<3> f1 = shape(0, 1) * edge_1 + shape(1, 1) * edge_2;
  const Vec<3> g(0.5 * (f0.squaredNorm() - 1), 0.5 * (f1.squaredNorm() - 1), f0.dot(f1));
  const MembraneResponse response = membrane_response(law, g, order);

  LocalEnergy<9> energy;
  energy.value = area * response.energy;
  if (order < Order::kGradient) return energy;
  const Vec<3>& S = response.stress;
  const Vec<3> p0 = area * (S[0] * f0 + S[2] * f1), p1 = area * (S[2] * f0 + S[1] * f1);
  energy.gradient.segment<3>(3) = shape(0, 0) * p0 + shape(0, 1) * p1;
  energy.gradient.tail<3>() = shape(1, 0) * p0 + shape(1, 1) * p1;
  energy.gradient.head<3>() = -energy.gradient.segment<3>(3) - energy.gradient.tail<3>();
  if (order < Order::kProjectedHessian) return energy;

  // The material part is positive semi-definite when the tangent is, the geometric part when the
  // stress is.
  const bool project = order == Order::kProjectedHessian;
  const Vec<3> geometric = project ? tensile_part(S) : S;
  const Mat<3> tangent = project && law.kind != MembraneLaw::Kind::kStVenantKirchhoff
                             ? positive_part(response.tangent)
                             : response.tangent;
  // Block of the corners with the hat gradients s, t: dg = (s_0 f0, s_1 f1, s_1 f0 + s_0 f1) dx_s.
  const auto block = [&](int row, int column) -> Mat<3> {
    const double s0 = area * shape(row, 0), s1 = area * shape(row, 1);
    const double t0 = shape(column, 0), t1 = shape(column, 1);
    const Vec<3> c0 = t0 * tangent.col(0) + t1 * tangent.col(2);
    const Vec<3> c1 = t1 * tangent.col(1) + t0 * tangent.col(2);
    const Vec<3> u = (s0 * c0[0] + s1 * c0[2]) * f0 + (s0 * c1[0] + s1 * c1[2]) * f1;
    const Vec<3> v = (s1 * c0[1] + s0 * c0[2]) * f0 + (s1 * c1[1] + s0 * c1[2]) * f1;
    Mat<3> sum = f0 * u.transpose() + f1 * v.transpose();
    sum.diagonal().array() +=
        s0 * (geometric[0] * t0 + geometric[2] * t1) + s1 * (geometric[2] * t0 + geometric[1] * t1);
    return sum;
  };
  const Mat<3> h11 = block(0, 0), h12 = block(0, 1), h22 = block(1, 1);
  const Mat<3> h10 = -h11 - h12, h20 = -h12.transpose() - h22;
  energy.hessian << -h10 - h20, h10.transpose(), h20.transpose(), h10, h11, h12, h20,
      h12.transpose(), h22;
  return energy;
}

}  // namespace pleat::sim
