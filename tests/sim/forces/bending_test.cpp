#include "sim/forces/bending.h"

#include <Eigen/Geometry>

#include "check_derivatives.h"
#include "core/random.h"
#include "sim/solver/assemble.h"

namespace pleat::sim {
namespace {

const Vec<2> kA(0, 0), kB(0.02, 0.003), kC(0.008, 0.017), kD(0.011, -0.015);
const Bending kBending = make_bending({0, 1, 2, 3}, {kA, kB, kC}, {kA, kB, kD}, 2e-6);
const auto energy = [](const Vec<12>& x, Order order) {
  return bending_energy(kBending, x, order);
};

Vec<12> flat() {
  Vec<12> x;
  x << kA, 0, kB, 0, kC, 0, kD, 0;
  return x;
}

TEST(Bending, DerivativesMatchDifferences) {
  RandomStream random(3, "bending");
  Vec<12> x = flat();
  for (int i = 0; i < 12; ++i) x[i] += 0.005 * random.normal();
  expect_derivatives_match<12>(energy, x);
  EXPECT_GE(smallest_eigenvalue<12>(energy, x), -1e-12);
}

TEST(Bending, FlatInAnyPlaneCostsNothing) {
  const Mat<3> turn = Eigen::AngleAxisd(0.7, Vec<3>(2, -1, 1).normalized()).toRotationMatrix();
  Vec<12> x = flat();
  for (int a = 0; a < 4; ++a) x.segment<3>(3 * a) = turn * x.segment<3>(3 * a) + Vec<3>(1, 2, 3);
  EXPECT_NEAR(energy(x, Order::kValue).value, 0, 1e-18);
}

TEST(Bending, KnowsNoSignOfCurvature) {
  Vec<12> up = flat(), down = flat();
  up[8] = 0.004;
  down[8] = -0.004;
  EXPECT_DOUBLE_EQ(energy(up, Order::kValue).value, energy(down, Order::kValue).value);
}

// Energy of an equilateral lattice of spacing h wound on a cylinder of radius R, over that of the
// plate, B / (2 R^2) a unit of area. Each hinge counts for a third of
// its two faces.
double cylinder_energy_ratio(double h, double axis_angle) {
  const double radius = 0.1, rigidity = 2e-6;
  const int side = static_cast<int>(0.2 / h);
  const Vec<2> along(std::cos(axis_angle), std::sin(axis_angle)), across(-along.y(), along.x());
  Points2 rest(side * side, 2);
  Eigen::VectorXd x(3 * side * side);
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const int v = j * side + i;
      const Vec<2> p(h * (i + 0.5 * j), h * std::sqrt(0.75) * j);
      rest.row(v) = p.transpose();
      const double s = across.dot(p) / radius;
      x.segment<3>(3 * v) << radius * std::sin(s), along.dot(p), radius * std::cos(s);
    }
  const int cells = side - 1;
  Faces faces(2 * cells * cells, 3);
  for (int j = 0, f = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      const int v = j * side + i;
      faces.row(f++) << v, v + 1, v + side;
      faces.row(f++) << v + 1, v + side + 1, v + side;
    }
  garment::FabricConfig fabric;
  fabric.bending_N_m = rigidity;
  const Cloth cloth = make_cloth(faces, faces, rest, side * side, fabric);
  double sum = 0, area = 0;
  for (const Bending& bending : cloth.bendings) {
    Vec<12> corners;
    for (int a = 0; a < 4; ++a) corners.segment<3>(3 * a) = x.segment<3>(3 * bending.vertices[a]);
    sum += bending_energy(bending, corners, Order::kValue).value;
    area += rigidity / bending.stiffness / 3;
  }
  return sum / area / (rigidity / (2 * radius * radius));
}

// The lattice's outline leaves its three directions with unequal numbers of hinges, an error that
// falls with h, hence the tolerances.
TEST(Bending, CylinderHoldsTheEnergyOfThePlateInEveryDirection) {
  for (double angle : {0.0, 0.2, 0.5236, 0.9, 1.5708}) {
    EXPECT_NEAR(cylinder_energy_ratio(0.01, angle), 1, 0.06) << angle;
    EXPECT_NEAR(cylinder_energy_ratio(0.0025, angle), 1, 0.015) << angle;
  }
}

}  // namespace
}  // namespace pleat::sim
