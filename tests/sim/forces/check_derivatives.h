// Central differences against a force's own gradient and Hessian.
#pragma once

#include <gtest/gtest.h>

#include "sim/forces/local_energy.h"

namespace pleat::sim {

// energy: Vec<N>, Order -> LocalEnergy<N>. Differences of step h err by O(h^2) in the derivative
// and O(eps/h) by rounding.
template <int N, typename Energy>
void expect_derivatives_match(const Energy& energy, const Vec<N>& x, double h = 1e-6,
                              double relative = 1e-5) {
  const LocalEnergy<N> at = energy(x, Order::kHessian);
  EXPECT_DOUBLE_EQ(energy(x, Order::kValue).value, at.value);
  Vec<N> gradient;
  Mat<N> hessian;
  for (int i = 0; i < N; ++i) {
    Vec<N> up = x, down = x;
    up[i] += h;
    down[i] -= h;
    gradient[i] = (energy(up, Order::kValue).value - energy(down, Order::kValue).value) / (2 * h);
    hessian.col(i) =
        (energy(up, Order::kGradient).gradient - energy(down, Order::kGradient).gradient) / (2 * h);
  }
  EXPECT_LE((gradient - at.gradient).norm(), relative * std::max(at.gradient.norm(), 1e-3));
  EXPECT_LE((hessian - at.hessian).norm(), relative * std::max(at.hessian.norm(), 1e-3));
}

template <int N, typename Energy>
double smallest_eigenvalue(const Energy& energy, const Vec<N>& x) {
  const Mat<N> hessian = energy(x, Order::kProjectedHessian).hessian;
  return Eigen::SelfAdjointEigenSolver<Mat<N>>(hessian).eigenvalues()[0] / hessian.norm();
}

}  // namespace pleat::sim
