#include "sim/forces/membrane.h"

#include <Eigen/Geometry>

#include "check_derivatives.h"
#include "core/random.h"

namespace pleat::sim {
namespace {

const std::array<Vec<2>, 3> kRest = {Vec<2>(0.01, 0.02), Vec<2>(0.035, 0.018), Vec<2>(0.02, 0.041)};
const Membrane kMembrane = make_membrane({0, 1, 2}, kRest, 300, 0.3);

Vec<9> flat(const Mat<3>& rotation = Mat<3>::Identity(), double stretch_x = 1,
            double stretch_y = 1) {
  Vec<9> x;
  for (int a = 0; a < 3; ++a)
    x.segment<3>(3 * a) = rotation * Vec<3>(stretch_x * kRest[a].x(), stretch_y * kRest[a].y(), 0);
  return x;
}

Vec<9> crumpled(int index) {
  RandomStream random(7, "membrane/" + std::to_string(index));
  Vec<9> x = flat();
  for (int i = 0; i < 9; ++i) x[i] += 0.01 * random.normal();
  return x;
}

const auto energy = [](const Vec<9>& x, Order order) {
  return membrane_energy(kMembrane, x, order);
};

TEST(Membrane, DerivativesMatchDifferences) {
  for (int i = 0; i < 20; ++i) expect_derivatives_match<9>(energy, crumpled(i));
}

TEST(Membrane, ProjectedHessianIsPositive) {
  for (int i = 0; i < 20; ++i) EXPECT_GE(smallest_eigenvalue<9>(energy, crumpled(i)), -1e-12);
}

TEST(Membrane, ProjectedHessianIsExactInTension) {
  const Vec<9> x = flat(Mat<3>::Identity(), 1.2, 1.1);
  EXPECT_LE(
      (energy(x, Order::kHessian).hessian - energy(x, Order::kProjectedHessian).hessian).norm(),
      1e-12 * energy(x, Order::kHessian).hessian.norm());
}

TEST(Membrane, RigidMotionCostsNothing) {
  const Mat<3> turn = Eigen::AngleAxisd(1.1, Vec<3>(1, 2, 3).normalized()).toRotationMatrix();
  Vec<9> x = flat(turn);
  for (int a = 0; a < 3; ++a) x.segment<3>(3 * a) += Vec<3>(3, -2, 1);
  EXPECT_NEAR(energy(x, Order::kValue).value, 0, 1e-14);
  EXPECT_LE(energy(x, Order::kGradient).gradient.norm(), 1e-9);
}

// Plane stress with G_xx = (s^2 - 1)/2 alone: E = A Y/(1-nu^2) G_xx^2 / 2.
TEST(Membrane, UniaxialStrainMatchesClosedForm) {
  const double s = 1.07, green = (s * s - 1) / 2;
  EXPECT_NEAR(energy(flat(Mat<3>::Identity(), s, 1), Order::kValue).value,
              kMembrane.area * 300 / (1 - 0.09) * green * green / 2, 1e-15);
}

}  // namespace
}  // namespace pleat::sim
