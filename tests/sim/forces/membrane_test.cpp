#include "sim/forces/membrane.h"

#include <Eigen/Geometry>
#include <cmath>

#include "check_derivatives.h"
#include "core/random.h"
#include "measured_fabrics.h"
#include "sim/solver/assemble.h"

namespace pleat::sim {
namespace {

const std::array<Vec<2>, 3> kRest = {Vec<2>(0.01, 0.02), Vec<2>(0.035, 0.018), Vec<2>(0.02, 0.041)};
const Membrane kMembrane = make_membrane({0, 1, 2}, kRest);

garment::Fabric isotropic(garment::MembraneModel model) {
  garment::Fabric fabric;
  fabric.membrane = model;
  return fabric;
}

std::map<std::string, garment::Fabric> all_fabrics() {
  std::map<std::string, garment::Fabric> fabrics = measured_fabrics();
  fabrics["stvk"] = isotropic(garment::MembraneModel::kStVenantKirchhoff);
  fabrics["neo_hookean"] = isotropic(garment::MembraneModel::kNeoHookean);
  return fabrics;
}

auto energy_of(const MembraneLaw& law) {
  return [&law](const Vec<9>& x, Order order) { return membrane_energy(kMembrane, law, x, order); };
}

Vec<9> flat(const Mat<3>& rotation = Mat<3>::Identity(), double stretch_x = 1,
            double stretch_y = 1) {
  Vec<9> x;
  for (int a = 0; a < 3; ++a)
    x.segment<3>(3 * a) = rotation * Vec<3>(stretch_x * kRest[a].x(), stretch_y * kRest[a].y(), 0);
  return x;
}

Vec<9> crumpled(int index, double size) {
  RandomStream random(7, "membrane/" + std::to_string(index));
  Vec<9> x = flat();
  for (int i = 0; i < 9; ++i) x[i] += size * random.normal();
  return x;
}

TEST(Membrane, DerivativesMatchDifferences) {
  for (const auto& [name, fabric] : all_fabrics()) {
    SCOPED_TRACE(name);
    const MembraneLaw law = make_membrane_law(fabric);
    for (int i = 0; i < 10; ++i) {
      expect_derivatives_match<9>(energy_of(law), crumpled(i, 0.001), 1e-8);
      expect_derivatives_match<9>(energy_of(law), crumpled(i, 0.005), 1e-7);
    }
  }
}

TEST(Membrane, ProjectedHessianIsPositive) {
  for (const auto& [name, fabric] : all_fabrics()) {
    const MembraneLaw law = make_membrane_law(fabric);
    for (int i = 0; i < 100; ++i)
      for (double size : {0.0003, 0.002, 0.008})
        EXPECT_GE(smallest_eigenvalue<9>(energy_of(law), crumpled(i, size)), -1e-12) << name;
  }
}

TEST(Membrane, ProjectedHessianIsExactInTension) {
  const Vec<9> x = flat(Mat<3>::Identity(), 1.2, 1.1);
  for (const auto model :
       {garment::MembraneModel::kStVenantKirchhoff, garment::MembraneModel::kNeoHookean}) {
    const MembraneLaw law = make_membrane_law(isotropic(model));
    const auto energy = energy_of(law);
    EXPECT_LE(
        (energy(x, Order::kHessian).hessian - energy(x, Order::kProjectedHessian).hessian).norm(),
        1e-12 * energy(x, Order::kHessian).hessian.norm());
  }
}

TEST(Membrane, RigidMotionCostsNothing) {
  const Mat<3> turn = Eigen::AngleAxisd(1.1, Vec<3>(1, 2, 3).normalized()).toRotationMatrix();
  for (const auto& [name, fabric] : all_fabrics()) {
    const MembraneLaw law = make_membrane_law(fabric);
    Vec<9> x = flat(turn);
    for (int a = 0; a < 3; ++a) x.segment<3>(3 * a) += Vec<3>(3, -2, 1);
    EXPECT_NEAR(energy_of(law)(x, Order::kValue).value, 0, 1e-14) << name;
    EXPECT_LE(energy_of(law)(x, Order::kGradient).gradient.norm(), 1e-9) << name;
    // And a turn of a stretched triangle changes nothing: rounding is 1e-15 of the energy.
    const double still = energy_of(law)(flat(Mat<3>::Identity(), 1.1, 0.97), Order::kValue).value;
    EXPECT_NEAR(energy_of(law)(flat(turn, 1.1, 0.97), Order::kValue).value, still, 1e-12 * still)
        << name;
  }
}

// A square patch, its inner points anywhere, deformed evenly by F: then no inner point feels a
// force, and the outline feels that of the law's stress.
struct Patch {
  static constexpr int kSide = 7;
  static constexpr double kLength = 0.3;  // m
  Points2 rest{kSide * kSide, 2};
  Faces faces{2 * (kSide - 1) * (kSide - 1), 3};

  Patch() {
    RandomStream random(1, "patch");
    const double cell = kLength / (kSide - 1);
    for (int v = 0; v < kSide * kSide; ++v) {
      const int i = v % kSide, j = v / kSide;
      const double shift = is_inner(v) ? 0.25 * cell : 0;
      rest.row(v) << i * cell + shift * (2 * random.uniform() - 1),
          j * cell + shift * (2 * random.uniform() - 1);
    }
    for (int c = 0; c < (kSide - 1) * (kSide - 1); ++c) {
      const int a = c % (kSide - 1) + kSide * (c / (kSide - 1)), b = a + kSide;
      faces.row(2 * c) << a, a + 1, b + 1;
      faces.row(2 * c + 1) << a, b + 1, b;
    }
  }
  static bool is_inner(int v) {
    const int i = v % kSide, j = v / kSide;
    return i > 0 && j > 0 && i < kSide - 1 && j < kSide - 1;
  }

  // Forces a metre on the side at the largest x (column 0) and at the largest y (column 1).
  Mat<2> pull(const garment::Fabric& fabric, const Mat<2>& F) const {
    garment::Fabric weightless = fabric;
    weightless.density_kg_per_m2 = 1e-12;
    const Cloth cloth = make_cloth(faces, faces, rest, kSide * kSide, weightless);
    Eigen::VectorXd x(3 * kSide * kSide);
    for (int v = 0; v < kSide * kSide; ++v) x.segment<3>(3 * v) << F * rest.row(v).transpose(), 0;
    System system;
    assemble(cloth, whole(cloth), {}, {}, x, Order::kGradient, system);
    Mat<2> sides = Mat<2>::Zero();
    for (int v = 0; v < kSide * kSide; ++v) {
      const Vec<2> force = system.gradient.segment<2>(3 * v);
      if (is_inner(v)) {
        EXPECT_LE(force.norm(), 1e-9) << v;
      }
      // At a corner another side pulls too, but at the opposite corner the same much back.
      if (v % kSide == kSide - 1) sides.col(0) += force / kLength;
      if (v / kSide == kSide - 1) sides.col(1) += force / kLength;
    }
    return sides;
  }
};

// The patch is uniform and its elements are linear, so that only rounding is left: 1e-9 of a
// stiffness of 300 N/m.
constexpr double kRounding = 3e-7;

Mat<2> deformation(double xx, double xy, double yx, double yy) {
  Mat<2> F;
  F << xx, xy, yx, yy;
  return F;
}

TEST(Membrane, PatchOfStVenantKirchhoffPullsAsItsClosedForm) {
  const garment::Fabric fabric = isotropic(garment::MembraneModel::kStVenantKirchhoff);
  const double young = fabric.youngs_modulus_N_per_m, nu = fabric.poisson_ratio;
  const double lambda = young * nu / (1 - nu * nu), mu = young / (2 * (1 + nu));
  const Patch patch;
  for (double s : {1.02, 1.2, 0.93}) {
    const double green = 0.5 * (s * s - 1);
    // Free sides: G_11 = -nu G_00, and the modulus is Young's.
    const double side = std::sqrt(1 - 2 * nu * green);
    EXPECT_LE(
        (patch.pull(fabric, deformation(s, 0, 0, side)) - deformation(young * green * s, 0, 0, 0))
            .norm(),
        kRounding);
    EXPECT_LE((patch.pull(fabric, deformation(s, 0, 0, s)) -
               young / (1 - nu) * green * s * Mat<2>::Identity())
                  .norm(),
              kRounding);
  }
  for (double k : {0.05, 0.3}) {
    const Mat<2> F = deformation(1, k, 0, 1);
    const double normal = lambda * k * k / 2;
    EXPECT_LE((patch.pull(fabric, F) - F * deformation(normal, mu * k, mu * k, normal + mu * k * k))
                  .norm(),
              kRounding);
  }
}

TEST(Membrane, PatchOfNeoHookeanPullsAsItsClosedForm) {
  const garment::Fabric fabric = isotropic(garment::MembraneModel::kNeoHookean);
  const double young = fabric.youngs_modulus_N_per_m, nu = fabric.poisson_ratio;
  const double lambda = young * nu / (1 - nu * nu), mu = young / (2 * (1 + nu));
  const Patch patch;
  for (double s : {1.02, 1.2, 0.7}) {
    double side = 1;  // mu (side^2 - 1) + lambda ln(s side) = 0: nothing pulls across
    for (int i = 0; i < 50; ++i)
      side -=
          (mu * (side * side - 1) + lambda * std::log(s * side)) / (2 * mu * side + lambda / side);
    EXPECT_LE((patch.pull(fabric, deformation(s, 0, 0, side)) -
               deformation(mu * (s - 1 / s) + lambda * std::log(s * side) / s, 0, 0, 0))
                  .norm(),
              kRounding);
    EXPECT_LE((patch.pull(fabric, deformation(s, 0, 0, s)) -
               (mu * (s - 1 / s) + 2 * lambda * std::log(s) / s) * Mat<2>::Identity())
                  .norm(),
              kRounding);
  }
  for (double k : {0.05, 0.3})  // no change of area: P = mu (F - F^-T)
    EXPECT_LE(
        (patch.pull(fabric, deformation(1, k, 0, 1)) - deformation(0, mu * k, mu * k, 0)).norm(),
        kRounding);
}

// Stretched by 1/6 along one axis of the panel, the length across held: the table's own number.
TEST(Membrane, PatchOfMeasuredFabricPullsAsItsTable) {
  const Patch patch;
  constexpr double s = 7.0 / 6, green = 13.0 / 72;
  for (const auto& [name, fabric] : measured_fabrics()) {
    const auto& table = fabric.tables->stretching;
    const double weft = patch.pull(fabric, deformation(s, 0, 0, 1))(0, 0);
    const double warp = patch.pull(fabric, deformation(1, 0, 0, s))(1, 1);
    EXPECT_NEAR(weft, 2 * table[1][0] * green * s, 1e-9 * weft) << name;
    EXPECT_NEAR(warp, 2 * table[5][2] * green * s, 1e-9 * warp) << name;
  }
}

}  // namespace
}  // namespace pleat::sim
