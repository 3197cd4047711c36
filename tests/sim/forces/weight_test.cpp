#include "sim/forces/weight.h"

#include "check_derivatives.h"

namespace pleat::sim {
namespace {

TEST(Weight, DerivativesMatchDifferences) {
  const auto energy = [](const Vec<3>& x, Order order) {
    return weight_energy({0, 0.002}, x, order);
  };
  expect_derivatives_match<3>(energy, Vec<3>(0.3, 1.2, -0.4));
}

TEST(Weight, PullsDownByItsMass) {
  const LocalEnergy<3> energy = weight_energy({0, 0.002}, {1, 2, 3}, Order::kHessian);
  EXPECT_EQ(energy.value, 0.002 * kGravity * 2);
  EXPECT_EQ(energy.gradient, Vec<3>(0, 0.002 * kGravity, 0));
  EXPECT_EQ(energy.hessian, Mat<3>::Zero());
}

}  // namespace
}  // namespace pleat::sim
