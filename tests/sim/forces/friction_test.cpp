#include "sim/forces/friction.h"

#include <Eigen/Geometry>
#include <cmath>

#include "check_derivatives.h"

namespace pleat::sim {
namespace {

const Vec<3> kNormal = Vec<3>(0.3, 0.9, -0.2).normalized();
const Vec<3> kTangent = kNormal.unitOrthogonal(), kSide = kNormal.cross(kTangent);
const Friction kFriction{0, Vec<3>(0.1, 0.2, 0.3), kNormal, 0.02, 20};
const double kSlip = kFriction.limit / kFriction.stiffness;  // 1 mm: where sliding begins

// Slipped by so much, a little above the surface.
Vec<3> slipped(double slip) {
  return kFriction.anchor + slip * kTangent + 0.003 * kNormal;
}
Vec<3> force(const Vec<3>& x) {
  return -friction_energy(kFriction, x, Order::kGradient).gradient;
}

TEST(Friction, DerivativesMatchDifferencesWhereItSticksAndWhereItSlides) {
  const auto energy = [](const Vec<3>& x, Order order) {
    return friction_energy(kFriction, x, order);
  };
  // Steps of 1e-5 of the slip where sliding begins.
  for (const double slip : {0.0, 0.2 * kSlip, 0.99 * kSlip, 1.01 * kSlip, 20 * kSlip})
    expect_derivatives_match<3>(energy, slipped(slip), 1e-8, 1e-6);
}

TEST(Friction, SticksByASpringThatDoesNotFeelTheLimit) {
  Friction pressed = kFriction;
  pressed.limit *= 3;
  for (const double slip : {0.0, 0.3 * kSlip, 0.9 * kSlip}) {
    EXPECT_LE((force(slipped(slip)) + kFriction.stiffness * slip * kTangent).norm(), 1e-15);
    const LocalEnergy<3> here = friction_energy(kFriction, slipped(slip), Order::kHessian);
    const LocalEnergy<3> there = friction_energy(pressed, slipped(slip), Order::kHessian);
    EXPECT_EQ(here.value, there.value);
    EXPECT_EQ(here.gradient, there.gradient);
    EXPECT_EQ(here.hessian, there.hessian);
  }
}

TEST(Friction, SlidesAgainstItsLimit) {
  for (const double slip : {1.001 * kSlip, 2 * kSlip, 50 * kSlip}) {
    EXPECT_LE((force(slipped(slip)) + kFriction.limit * kTangent).norm(), 1e-14);
    // What was slipped beyond the spring costs the limit times the way.
    EXPECT_NEAR(friction_energy(kFriction, slipped(slip), Order::kValue).value,
                0.5 * kFriction.limit * kSlip + kFriction.limit * (slip - kSlip), 1e-15);
  }
}

TEST(Friction, NeverExceedsCoulombsLimitAndOpposesSlip) {
  for (double slip = 1e-7; slip < 1; slip *= 1.7)
    for (double angle = 0; angle < 6; angle += 0.5) {
      const Vec<3> way = std::cos(angle) * kTangent + std::sin(angle) * kSide;
      const Vec<3> pull = force(kFriction.anchor + slip * way - 0.002 * kNormal);
      EXPECT_LE(pull.norm(), kFriction.limit * (1 + 1e-12));
      EXPECT_NEAR(pull.dot(way), -pull.norm(), 1e-15);
      EXPECT_GT(pull.norm(), 0);
      EXPECT_NEAR(pull.dot(kNormal), 0, 1e-16);
    }
}

// Of energy and force: across the limit they change by no more than the step allows, up to the
// rounding of positions, 1e-16 m times the limit.
TEST(Friction, IsContinuousWhereSlidingBegins) {
  const double step = 1e-9 * kSlip;
  const LocalEnergy<3> below = friction_energy(kFriction, slipped(kSlip - step), Order::kGradient);
  const LocalEnergy<3> above = friction_energy(kFriction, slipped(kSlip + step), Order::kGradient);
  EXPECT_NEAR(above.value - below.value, 2 * step * kFriction.limit, 3e-18);
  EXPECT_LE((above.gradient - below.gradient).norm(), 2 * kFriction.stiffness * step);
}

// Along the slip there is no stiffness left where it slides, across it what the turning force
// gives.
TEST(Friction, HessianIsPositive) {
  const auto energy = [](const Vec<3>& x, Order order) {
    return friction_energy(kFriction, x, order);
  };
  for (const double slip : {0.0, 0.5 * kSlip, 1.5 * kSlip, 30 * kSlip}) {
    EXPECT_GE(smallest_eigenvalue<3>(energy, slipped(slip)), -1e-15);
    EXPECT_EQ(energy(slipped(slip), Order::kProjectedHessian).hessian,
              energy(slipped(slip), Order::kHessian).hessian);
  }
  const Mat<3> sliding = energy(slipped(4 * kSlip), Order::kHessian).hessian;
  EXPECT_NEAR(kTangent.dot(sliding * kTangent), 0, 1e-12);
  EXPECT_NEAR(kSide.dot(sliding * kSide), kFriction.stiffness / 4, 1e-12);
  EXPECT_NEAR(kNormal.dot(sliding * kNormal), 0, 1e-12);
}

TEST(Friction, WithoutPressureSlidesForNothing) {
  Friction loose = kFriction;
  loose.limit = 0;
  const LocalEnergy<3> there = friction_energy(loose, slipped(kSlip), Order::kHessian);
  EXPECT_EQ(there.value, 0);
  EXPECT_EQ(there.gradient, Vec<3>::Zero());
  EXPECT_EQ(there.hessian, Mat<3>::Zero());
}

}  // namespace
}  // namespace pleat::sim
