#include "sim/solver/assemble.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "measured_fabrics.h"

namespace pleat::sim {
namespace {

// A small sheet, crumpled: every kind of element with its neighbours.
struct Sheet {
  static constexpr int kSide = 6;
  Points2 rest{kSide * kSide, 2};
  Faces faces{2 * (kSide - 1) * (kSide - 1), 3};
  Eigen::VectorXd x{3 * kSide * kSide};

  Sheet() {
    RandomStream random(2, "sheet");
    for (int v = 0; v < kSide * kSide; ++v) {
      rest.row(v) << 0.02 * (v % kSide), 0.02 * (v / kSide);
      x.segment<3>(3 * v) << rest(v, 0), rest(v, 1), 0;
    }
    for (double& coordinate : x) coordinate += 0.002 * random.normal();
    for (int c = 0; c < (kSide - 1) * (kSide - 1); ++c) {
      const int a = c % (kSide - 1) + kSide * (c / (kSide - 1)), b = a + kSide;
      faces.row(2 * c) << a, a + 1, b + 1;
      faces.row(2 * c + 1) << a, b + 1, b;
    }
  }
};

// Central differences of 1e-8 m along a random direction: what is left of the step is 1e-6 of the
// stiffness, and of rounding less.
TEST(Assemble, GradientAndHessianAreDerivativesOfTheEnergy) {
  const Sheet sheet;
  garment::Fabric neo_hookean;
  neo_hookean.membrane = garment::MembraneModel::kNeoHookean;
  for (const garment::Fabric& fabric :
       {garment::Fabric{}, neo_hookean, measured_fabric("gray_interlock")}) {
    const Cloth cloth =
        make_cloth(sheet.faces, sheet.faces, sheet.rest, Sheet::kSide * Sheet::kSide, fabric);
    RandomStream random(3, "direction");
    Eigen::VectorXd direction(sheet.x.size()), product;
    for (double& number : direction) number = random.normal();
    const double h = 1e-8;
    System at, up, down;
    assemble(cloth, {}, sheet.x, Order::kHessian, at);
    assemble(cloth, {}, sheet.x + h * direction, Order::kGradient, up);
    assemble(cloth, {}, sheet.x - h * direction, Order::kGradient, down);
    EXPECT_NEAR((up.energy - down.energy) / (2 * h), at.gradient.dot(direction),
                1e-6 * at.gradient.norm() * direction.norm());
    multiply(at.hessian, direction, product);
    EXPECT_LE(((up.gradient - down.gradient) / (2 * h) - product).norm(), 1e-5 * product.norm());
    Eigen::VectorXd other(sheet.x.size()), other_product;
    for (double& number : other) number = random.normal();
    multiply(at.hessian, other, other_product);  // and it is symmetric
    EXPECT_NEAR(other.dot(product), direction.dot(other_product),
                1e-12 * product.norm() * other.norm());
  }
}

}  // namespace
}  // namespace pleat::sim
