#include "sim/forces/membrane.h"

#include <Eigen/LU>

namespace pleat::sim {

Membrane make_membrane(const std::array<int, 3>& vertices, const std::array<Vec<2>, 3>& rest,
                       double youngs_modulus, double poisson_ratio) {
  Mat<2> edges;
  edges << rest[1] - rest[0], rest[2] - rest[0];
  Membrane membrane;
  membrane.vertices = vertices;
  membrane.inverse_rest = edges.inverse();
  membrane.area = 0.5 * std::abs(edges.determinant());
  membrane.lambda = youngs_modulus * poisson_ratio / (1 - poisson_ratio * poisson_ratio);
  membrane.mu = youngs_modulus / (2 * (1 + poisson_ratio));
  return membrane;
}

LocalEnergy<9> membrane_energy(const Membrane& membrane, const Vec<9>& x, Order order) {
  // Row a of `shape` is the gradient of the hat function of corner a in the rest plane: F = sum_a
  // x_a shape_a.
  Eigen::Matrix<double, 3, 2> shape;
  shape.row(1) = membrane.inverse_rest.row(0);
  shape.row(2) = membrane.inverse_rest.row(1);
  shape.row(0) = -shape.row(1) - shape.row(2);
  const Eigen::Map<const Mat<3>> corners(x.data());  // column a: corner a
  const Eigen::Matrix<double, 3, 2> F = corners * shape;
  const Mat<2> G = 0.5 * (F.transpose() * F - Mat<2>::Identity());

  LocalEnergy<9> energy;
  const double trace = G.trace();
  energy.value =
      membrane.area * (0.5 * membrane.lambda * trace * trace + membrane.mu * G.squaredNorm());
  if (order < Order::kGradient) return energy;

  Mat<2> S =
      membrane.lambda * trace * Mat<2>::Identity() + 2 * membrane.mu * G;  // second Piola-Kirchhoff
  const Eigen::Matrix<double, 3, 2> P = F * S;
  Eigen::Map<Mat<3>>(energy.gradient.data()) = membrane.area * P * shape.transpose();
  if (order < Order::kProjectedHessian) return energy;

  // dG = sym(F^T dF) gives the material part, which is positive semi-definite; S dF the geometric
  // one, which is so exactly when S is.
  if (order == Order::kProjectedHessian) S = clamp_to_positive<2>(S);
  const Mat<3> geometric = membrane.area * shape * S * shape.transpose();
  Eigen::Matrix<double, 3, 9> strain;  // rows: dG_00, dG_11, 2 dG_01
  for (int a = 0; a < 3; ++a) {
    strain.block<1, 3>(0, 3 * a) = shape(a, 0) * F.col(0).transpose();
    strain.block<1, 3>(1, 3 * a) = shape(a, 1) * F.col(1).transpose();
    strain.block<1, 3>(2, 3 * a) =
        shape(a, 0) * F.col(1).transpose() + shape(a, 1) * F.col(0).transpose();
  }
  const double lambda = membrane.lambda, mu = membrane.mu;
  Mat<3> stiffness;
  stiffness << lambda + 2 * mu, lambda, 0, lambda, lambda + 2 * mu, 0, 0, 0, mu;
  energy.hessian.noalias() = strain.transpose() * (membrane.area * stiffness) * strain;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      for (int c = 0; c < 3; ++c) energy.hessian(3 * a + c, 3 * b + c) += geometric(a, b);
  return energy;
}

}  // namespace pleat::sim
