// What one element of a force gives the solver. A force is one header: formula, source, what an
// element stores, and one pure function of the element and of its stacked points.
#pragma once

#include <Eigen/Eigenvalues>

#include "core/types.h"

namespace pleat::sim {

// Each order also fills the lower ones. kProjectedHessian is positive semi-definite, kHessian is
// exact.
enum class Order { kValue, kGradient, kProjectedHessian, kHessian };

// Fields above the order that was asked for hold nothing: to clear them would cost more than many
// an energy.
template <int N>
struct LocalEnergy {
  double value;     // J
  Vec<N> gradient;  // J/m
  Mat<N> hessian;   // J/m^2
};

// The nearest positive semi-definite matrix in the Frobenius norm: negative eigenvalues to zero.
template <int N>
Mat<N> clamp_to_positive(const Mat<N>& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Mat<N>> eigen(symmetric);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() *
         eigen.eigenvectors().transpose();
}

}  // namespace pleat::sim
