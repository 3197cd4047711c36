#include "check_derivatives.h"
#include "sim/forces/contact.h"
#include "sim/forces/friction.h"
#include "sim/forces/weight.h"

namespace pleat::sim {
namespace {

const Vec<3> kNormal = Vec<3>(0.3, 0.9, -0.2).normalized();
const Vec<3> kTangent = kNormal.unitOrthogonal();
const Contact kContact{0, 0, Vec<3>(1, 0, 0), Vec<3>(0.1, 0.2, 0.3), kNormal, 0.003, 900};
const Friction kFriction{0, Vec<3>(0.1, 0.2, 0.3), kNormal, 0.02, 0.0005};

TEST(Weight, DerivativesMatchDifferences) {
  const auto energy = [](const Vec<3>& x, Order order) {
    return weight_energy({0, 0.002}, x, order);
  };
  expect_derivatives_match<3>(energy, Vec<3>(0.3, 1.2, -0.4));
}

TEST(Contact, DerivativesMatchDifferencesInEveryRegime) {
  const auto energy = [](const Vec<3>& x, Order order) {
    return contact_energy(kContact, x, order);
  };
  for (double gap : {0.004, 0.0021, 0.0004, -0.002, -0.01})
    expect_derivatives_match<3>(energy, kContact.point + gap * kNormal + 0.002 * kTangent, 1e-7);
}

TEST(Contact, PushesOutwardOnlyWithinItsDistance) {
  EXPECT_EQ(normal_force(kContact, kContact.point + 0.0031 * kNormal), 0);
  double last = 0;
  for (double gap : {0.0029, 0.002, 0.001, 0.0, -0.001, -0.005}) {
    const Vec<3> x = kContact.point + gap * kNormal;
    const double force = normal_force(kContact, x);
    EXPECT_GT(force, last);
    EXPECT_NEAR((contact_energy(kContact, x, Order::kGradient).gradient + force * kNormal).norm(),
                0, 1e-12);
    last = force;
  }
}

TEST(Friction, DerivativesMatchDifferences) {
  const auto energy = [](const Vec<3>& x, Order order) {
    return friction_energy(kFriction, x, order);
  };
  for (double slip : {0.0002, 0.0012, 0.02})
    expect_derivatives_match<3>(energy, kFriction.anchor + slip * kTangent + 0.003 * kNormal, 1e-8,
                                1e-4);
}

TEST(Friction, NeverExceedsCoulombsLimitAndOpposesSlip) {
  for (double slip : {0.0001, 0.0004, 0.001, 0.05}) {
    const Vec<3> x = kFriction.anchor + slip * kTangent;
    const Vec<3> force = -friction_energy(kFriction, x, Order::kGradient).gradient;
    EXPECT_LE(force.norm(), kFriction.limit * (1 + 1e-12));
    EXPECT_LT(force.dot(kTangent), 0);
    EXPECT_NEAR(force.dot(kNormal), 0, 1e-15);
  }
}

}  // namespace
}  // namespace pleat::sim
