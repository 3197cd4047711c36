#include "sim/forces/membrane.h"

#include <Eigen/Geometry>
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

double sum_of_minors(const Mat<3>& m) {
  return m(0, 0) * m(1, 1) + m(0, 0) * m(2, 2) + m(1, 1) * m(2, 2) - m(0, 1) * m(0, 1) -
         m(0, 2) * m(0, 2) - m(1, 2) * m(1, 2);
}

// The 3 x 3 tangent without its negative eigenvalues. Mostly there is none, and seldom more than
// one: its vector is taken out, which costs a fourth of the whole decomposition.
Mat<3> positive_part(const Mat<3>& tangent) {
  const double minor = tangent(0, 0) * tangent(1, 1) - tangent(0, 1) * tangent(1, 0);
  const double determinant = tangent.determinant();
  if (tangent(0, 0) > 0 && minor > 0 && determinant > 0) return tangent;

  // Newton's method from below the smallest root of the characteristic polynomial, where it is
  // convex, so that no step passes the root.
  const double trace = tangent.trace(), minors = sum_of_minors(tangent), size = tangent.norm();
  double least = -size, last;
  int steps = 0;
  do {
    last = least;
    const double value = determinant - last * (minors - last * (trace - last));
    const double slope = -minors + last * (2 * trace - 3 * last);
    least = last - value / slope;
  } while (least > last && least < size && ++steps < 40);
  // Columns of the adjugate are multiples of its eigenvector; the longest is the most exact.
  const Mat<3> shifted = tangent - last * Mat<3>::Identity();
  Vec<3> vector = shifted.col(0).cross(shifted.col(1));
  for (int k = 1; k < 3; ++k) {
    const Vec<3> other = shifted.col(k).cross(shifted.col((k + 1) % 3));
    if (other.squaredNorm() > vector.squaredNorm()) vector = other;
  }
  const Mat<3> rest = tangent - last / vector.squaredNorm() * vector * vector.transpose();
  const bool is_positive = last < 0 && rest.trace() >= 0 && sum_of_minors(rest) >= 0;
  return is_positive ? rest : clamp_to_positive<3>(tangent);
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
