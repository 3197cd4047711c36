#include "sim/forces/bending.h"

#include <Eigen/Geometry>
#include <cmath>

#include "check_derivatives.h"
#include "core/random.h"
#include "measured_fabrics.h"
#include "sim/solver/assemble.h"

namespace pleat::sim {
namespace {

const Vec<2> kA(0, 0), kB(0.02, 0.003), kC(0.008, 0.017), kD(0.011, -0.015);
const Bending kBending = make_bending({0, 1, 2, 3}, {kA, kB, kC}, {kA, kB, kD});

garment::Fabric constant(double rigidity) {
  garment::Fabric fabric;
  fabric.bending_N_m = rigidity;
  return fabric;
}
std::map<std::string, garment::Fabric> all_fabrics() {
  std::map<std::string, garment::Fabric> fabrics = measured_fabrics();
  fabrics["constant"] = constant(2e-6);
  return fabrics;
}

auto energy_of(const BendingLaw& law) {
  return [&law](const Vec<12>& x, Order order) { return bending_energy(kBending, law, x, order); };
}

Vec<12> flat() {
  Vec<12> x;
  x << kA, 0, kB, 0, kC, 0, kD, 0;
  return x;
}
// Folded along the edge: the corner of the first face by `height` out of the plane.
Vec<12> folded(double height) {
  Vec<12> x = flat();
  x[8] = height;
  return x;
}

TEST(Bending, DerivativesMatchDifferences) {
  for (const auto& [name, fabric] : all_fabrics()) {
    SCOPED_TRACE(name);
    const BendingLaw law = make_bending_law(fabric);
    for (double size : {0.0002, 0.001, 0.005}) {
      RandomStream random(3, "bending");
      Vec<12> x = flat();
      for (int i = 0; i < 12; ++i) x[i] += size * random.normal();
      expect_derivatives_match<12>(energy_of(law), x, 1e-7);
    }
  }
}

// Convex: the exact Hessian needs no projection.
TEST(Bending, HessianIsPositive) {
  for (const auto& [name, fabric] : all_fabrics()) {
    const BendingLaw law = make_bending_law(fabric);
    RandomStream random(4, name);
    for (double size : {1e-6, 0.0002, 0.001, 0.005})
      for (int i = 0; i < 50; ++i) {
        Vec<12> x = flat();
        for (int k = 0; k < 12; ++k) x[k] += size * random.normal();
        EXPECT_GE(smallest_eigenvalue<12>(energy_of(law), x), -1e-12) << name;
        EXPECT_EQ(energy_of(law)(x, Order::kHessian).hessian,
                  energy_of(law)(x, Order::kProjectedHessian).hessian);
      }
  }
}

TEST(Bending, FlatInAnyPlaneCostsNothing) {
  const Mat<3> turn = Eigen::AngleAxisd(0.7, Vec<3>(2, -1, 1).normalized()).toRotationMatrix();
  for (const auto& [name, fabric] : all_fabrics()) {
    const BendingLaw law = make_bending_law(fabric);
    Vec<12> x = flat(), bent = folded(0.004);
    const double still = energy_of(law)(bent, Order::kValue).value;
    for (int a = 0; a < 4; ++a) {
      x.segment<3>(3 * a) = turn * x.segment<3>(3 * a) + Vec<3>(1, 2, 3);
      bent.segment<3>(3 * a) = turn * bent.segment<3>(3 * a) + Vec<3>(1, 2, 3);
    }
    EXPECT_NEAR(energy_of(law)(x, Order::kValue).value, 0, 1e-18) << name;
    EXPECT_NEAR(energy_of(law)(bent, Order::kValue).value, still, 1e-11 * still) << name;
  }
}

// By magnitude, never by sign: ARCSim looks its tables up by signed curvature, and its cloth folds
// more easily one way.
TEST(Bending, FoldUpIsFoldDown) {
  for (const auto& [name, fabric] : all_fabrics()) {
    const BendingLaw law = make_bending_law(fabric);
    for (double height : {0.0001, 0.001, 0.004, 0.01}) {
      const LocalEnergy<12> up = energy_of(law)(folded(height), Order::kHessian);
      const LocalEnergy<12> down = energy_of(law)(folded(-height), Order::kHessian);
      Vec<12> mirror = Vec<12>::Ones();
      for (int a = 0; a < 4; ++a) mirror[3 * a + 2] = -1;
      EXPECT_EQ(up.value, down.value) << name;
      EXPECT_EQ(up.gradient, mirror.cwiseProduct(down.gradient)) << name;
      EXPECT_EQ(up.hessian, mirror.asDiagonal() * down.hessian * mirror.asDiagonal()) << name;
    }
  }
}

// Of a small fold by theta, with the table's first number k: k |e|^2 theta^2 / (8 (A_0 + A_1)), as
// the table's force has it. A fold by 0.001 is a curvature of 0.06 1/m, where the moment has left
// its first slope by less than 1 %. No monotone curve starts steeper than three times its chord.
TEST(Bending, SmallFoldFollowsTheTablesForce) {
  const double length = (kB - kA).norm(), theta = 0.001;
  const Vec<3> edge = Vec<3>(kB.x(), kB.y(), 0).normalized();
  Vec<12> x = flat();
  x.segment<3>(6) = Eigen::AngleAxisd(theta, edge) * x.segment<3>(6);
  const double angle = std::atan2(kB.y(), kB.x()) / (M_PI / 4);
  for (const auto& [name, fabric] : measured_fabrics()) {
    const auto& table = fabric.tables->bending;
    const double first = (1 - angle) * std::min(table[0][0], 3 * table[0][1]) +
                         angle * std::min(table[1][0], 3 * table[1][1]);
    const double energy = energy_of(make_bending_law(fabric))(x, Order::kValue).value;
    const double expected = first * length * length * theta * theta / (8 * kBending.area);
    EXPECT_NEAR(energy, expected, 0.01 * expected) << name;
  }
}

TEST(Bending, DirectionIsTheFoldsInThePanel) {
  const auto weights = [](double degrees) -> Vec<3> {
    const Mat<2> turn = Eigen::Rotation2Dd(degrees * M_PI / 180).toRotationMatrix();
    const std::array<Vec<2>, 3> up = {turn * Vec<2>(0, 0), turn * Vec<2>(1, 0),
                                      turn * Vec<2>(0.5, 1)};
    const std::array<Vec<2>, 3> down = {turn * Vec<2>(0, 0), turn * Vec<2>(1, 0),
                                        turn * Vec<2>(0.5, -1)};
    return make_bending({0, 1, 2, 3}, up, down).directions;
  };
  const auto expect_weights = [&](double degrees, const Vec<3>& expected) {
    EXPECT_LE((weights(degrees) - expected).norm(), 1e-12) << degrees;
  };
  for (double quadrant : {0.0, 180.0}) {
    expect_weights(quadrant, Vec<3>(1, 0, 0));
    expect_weights(quadrant + 90, Vec<3>(0, 0, 1));
    for (double sign : {-1.0, 1.0}) {
      expect_weights(quadrant + sign * 45, Vec<3>(0, 1, 0));
      expect_weights(quadrant + sign * 15, Vec<3>(2, 1, 0) / 3);
      expect_weights(quadrant + sign * 75, Vec<3>(0, 1, 2) / 3);
    }
  }
}

// A seam bends as its two sides do, each in its own direction.
TEST(Bending, SeamMixesItsSides) {
  const std::array<Vec<2>, 3> across = {Vec<2>(0, 0), Vec<2>(1, 0), Vec<2>(0.5, 1)};
  const std::array<Vec<2>, 3> along = {Vec<2>(7, 0), Vec<2>(7, 1), Vec<2>(10, 0.5)};
  EXPECT_LE((make_bending({0, 1, 2, 3}, across, along).directions - Vec<3>(0.25, 0, 0.75)).norm(),
            1e-12);
}

// An equilateral lattice of spacing h wound on a cylinder of radius 0.1 m, whose axis lies at an
// angle to the lattice's first direction, which is the panel's axis 0 or axis 1.
struct Cylinder {
  static constexpr double kRadius = 0.1;
  double energy = 0;         // J
  double area = 0;           // m^2: each hinge counts for a third of its two faces
  double straight_area = 0;  // m^2: the two faces of each hinge along the lattice's first direction

  Cylinder(const garment::Fabric& fabric, double h, double axis_angle, bool is_turned = false) {
    const int side = static_cast<int>(0.2 / h);
    const Vec<2> along(std::cos(axis_angle), std::sin(axis_angle)), across(-along.y(), along.x());
    Points2 rest(side * side, 2);
    Eigen::VectorXd x(3 * side * side);
    for (int j = 0; j < side; ++j)
      for (int i = 0; i < side; ++i) {
        const int v = j * side + i;
        const Vec<2> p(h * (i + 0.5 * j), h * std::sqrt(0.75) * j);
        rest.row(v) = (is_turned ? Vec<2>(-p.y(), p.x()) : p).transpose();
        const double s = across.dot(p) / kRadius;
        x.segment<3>(3 * v) << kRadius * std::sin(s), along.dot(p), kRadius * std::cos(s);
      }
    const int cells = side - 1;
    Faces faces(2 * cells * cells, 3);
    for (int j = 0, f = 0; j < cells; ++j)
      for (int i = 0; i < cells; ++i) {
        const int v = j * side + i;
        faces.row(f++) << v, v + 1, v + side;
        faces.row(f++) << v + 1, v + side + 1, v + side;
      }
    const Cloth cloth = make_cloth(faces, faces, rest, side * side, fabric);
    for (const Bending& bending : cloth.bendings) {
      Vec<12> corners;
      for (int a = 0; a < 4; ++a) corners.segment<3>(3 * a) = x.segment<3>(3 * bending.vertices[a]);
      energy += bending_energy(bending, cloth.bending_law, corners, Order::kValue).value;
      area += bending.area / 3;
      const int step = bending.vertices[1] - bending.vertices[0];
      if (std::abs(step) == 1) straight_area += bending.area;
    }
  }
};

// The lattice's outline leaves its three directions with unequal numbers of hinges, an error that
// falls with h, hence the tolerances.
TEST(Bending, CylinderHoldsTheEnergyOfThePlateInEveryDirection) {
  const double plate = 2e-6 / (2 * Cylinder::kRadius * Cylinder::kRadius);  // J/m^2
  for (double angle : {0.0, 0.2, 0.5236, 0.9, 1.5708}) {
    const Cylinder coarse(constant(2e-6), 0.01, angle), fine(constant(2e-6), 0.0025, angle);
    EXPECT_NEAR(coarse.energy / coarse.area, plate, 0.06 * plate) << angle;
    EXPECT_NEAR(fine.energy / fine.area, plate, 0.015 * plate) << angle;
  }
}

// Bent about a direction of the lattice, only the hinges along it fold, by the cylinder's
// curvature: a unit of area holds the integral of the table's moment, up to h^2 / R^2.
TEST(Bending, CylinderOfMeasuredFabricHoldsTheIntegralOfItsMoment) {
  constexpr double kCurvature = 1 / Cylinder::kRadius;
  for (const auto& [name, fabric] : measured_fabrics()) {
    const BendingLaw law = make_bending_law(fabric);
    for (const bool is_turned : {false, true}) {
      const Vec<3> fold = is_turned ? Vec<3>(0, 0, 1) : Vec<3>(1, 0, 0);
      double integral = 0;  // by Simpson's rule
      constexpr int kSteps = 100;
      for (int i = 0; i <= kSteps; ++i) {
        const double c = kCurvature * i / kSteps;
        const double weight = i == 0 || i == kSteps ? 1 : i % 2 == 1 ? 4 : 2;
        integral +=
            weight * kCurvature / kSteps / 3 * c * measured_bending(law, fold, c).secant_rigidity;
      }
      const Cylinder wound(fabric, 0.0025, 0, is_turned);
      EXPECT_NEAR(wound.energy / wound.straight_area, integral, 0.002 * integral)
          << name << " " << is_turned;
    }
  }
}

TEST(Bending, WarpAndWeftDiffer) {
  for (const std::string name : {"black_denim", "gray_interlock", "pink_ribbon_brown"}) {
    const garment::Fabric fabric = measured_fabric(name);
    const double weft = Cylinder(fabric, 0.005, 0).energy;
    const double warp = Cylinder(fabric, 0.005, 0, true).energy;
    EXPECT_GT(std::abs(std::log(warp / weft)), 0.2) << name;
  }
}

}  // namespace
}  // namespace pleat::sim
