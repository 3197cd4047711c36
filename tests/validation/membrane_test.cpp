// Cloth stretched and sheared against the closed form of its law.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "core/random.h"
#include "tests/validation/scene.h"

namespace pleat::sim {
namespace {

constexpr double kTolerance = 1e-3;

garment::Fabric isotropic(garment::MembraneModel model) {
  garment::Fabric fabric;
  fabric.membrane = model;
  return fabric;
}

// P = F S by hand, N/m, of the two isotropic laws in plane stress.
Mat<2> expected_stress(const garment::Fabric& fabric, const Mat<2>& F) {
  const double nu = fabric.poisson_ratio, y = fabric.youngs_modulus_N_per_m;
  const double mu = y / (2 * (1 + nu)), lambda = y * nu / (1 - nu * nu);
  const Mat<2> C = F.transpose() * F, I = Mat<2>::Identity();
  if (fabric.membrane == garment::MembraneModel::kStVenantKirchhoff)
    return F * (0.5 * lambda * (C - I).trace() * I + mu * (C - I));
  return F * (mu * (I - C.inverse()) + lambda * std::log(F.determinant()) * C.inverse());
}

// A square whose rim is held at F X while the inside, pushed about, finds its place. What holds the
// rim gives the mean stress, whatever the inside does: P = 1/A sum f X^T.
Mat<2> measured_stress(const garment::Fabric& fabric, const Mat<2>& F) {
  constexpr double kSize = 0.2;
  constexpr int kCells = 10;
  garment::Fabric light = fabric;
  light.density_kg_per_m2 = 1e-6;
  const Sheet sheet = make_grid({kSize, kSize}, kCells, kCells, Diagonal::kRising);
  Cloth cloth = make_cloth(sheet, light);
  cloth.weight_norm = 30 * (F - Mat<2>::Identity()).norm() * kSize;  // N, about what pulls
  pin(cloth, [&](int v) {
    const int i = v % (kCells + 1), j = v / (kCells + 1);
    return i == 0 || j == 0 || i == kCells || j == kCells;
  });
  RandomStream random(1, "membrane");
  DrapeState state = at_rest(place(sheet, [&](const Vec<2>& rest) {
    const Vec<2> x = F * rest;
    return Vec<3>(x[0], 0, -x[1]);
  }));
  for (int v = 0; v < cloth.vertex_count; ++v)
    if (!cloth.is_pinned[v])
      for (int k = 0; k < 3; ++k) state.x[3 * v + k] += 0.002 * (2 * random.uniform() - 1);
  const TriangleMesh nobody = make_nobody();
  const BodyCollider body(nobody.vertices, nobody.faces);
  const Stage stage{body, 0, {}, {1e-3, 300, 0.01}};
  const NewtonResult result = settle(cloth, stage, state);
  EXPECT_TRUE(result.has_converged) << result.residual;
  const Points3 force = forces_on(cloth, stage, state);  // of the cloth on the rim
  Mat<2> sum = Mat<2>::Zero();
  for (int v = 0; v < cloth.vertex_count; ++v)
    if (cloth.is_pinned[v])
      sum -= Vec<2>(force(v, 0), -force(v, 2)) * sheet.rest.row(v);
  return sum / (kSize * kSize);
}

void expect_stress(const std::string& name, const garment::Fabric& fabric, const Mat<2>& F) {
  const Mat<2> expected = expected_stress(fabric, F), measured = measured_stress(fabric, F);
  report(name + ": error of the stress", (measured - expected).norm() / expected.norm(), "");
  EXPECT_LE((measured - expected).norm(), kTolerance * expected.norm())
      << name << "\n" << measured << "\nexpected\n" << expected;
}

class Law : public testing::TestWithParam<garment::MembraneModel> {};

TEST_P(Law, HoldsBiaxialStretchAndShear) {
  const garment::Fabric fabric = isotropic(GetParam());
  const std::string name = garment::name_of(GetParam());
  Mat<2> F;
  F << 1.15, 0, 0, 1.15;
  expect_stress(name + ", stretched alike", fabric, F);
  F << 1.25, 0, 0, 1.05;
  expect_stress(name + ", stretched unlike", fabric, F);
  F << 1.1, 0.15, 0, 1.1;  // stretched as well, or it would buckle
  expect_stress(name + ", sheared", fabric, F);
}

// A strip that hangs from its upper edge with a load along the lower one, its own weight next to
// nothing. The upper edge is as narrow as the strip becomes, so that the stretch is even.
TEST_P(Law, HangingLoadStretchesAndNarrows) {
  garment::Fabric fabric = isotropic(GetParam());
  fabric.density_kg_per_m2 = 1e-6;
  const double width = 0.05, length = 0.15, load = 15;  // N/m

  // The stretch whose stress is the load, the narrowing for which none acts across.
  double along = 1, across = 1;
  for (int i = 0; i < 200; ++i) {
    const auto stress = [&](double l, double t) {
      return expected_stress(fabric, Vec<2>(t, l).asDiagonal());
    };
    const double h = 1e-6;
    const Mat<2> p = stress(along, across);
    Mat<2> slope;
    slope << (stress(along + h, across)(1, 1) - p(1, 1)) / h,
        (stress(along, across + h)(1, 1) - p(1, 1)) / h,
        (stress(along + h, across)(0, 0) - p(0, 0)) / h,
        (stress(along, across + h)(0, 0) - p(0, 0)) / h;
    const Vec<2> step = slope.inverse() * Vec<2>(load - p(1, 1), -p(0, 0));
    along += step[0];
    across += step[1];
  }

  constexpr int kColumns = 6, kRows = 18, kStride = kColumns + 1;
  const Sheet sheet = make_grid({width, length}, kColumns, kRows, Diagonal::kAlternating);
  Cloth cloth = make_cloth(sheet, fabric);
  pin(cloth, [&](int v) { return v >= kRows * kStride; });
  for (int i = 0; i <= kColumns; ++i) {
    const double share = (i == 0 || i == kColumns ? 0.5 : 1.0) * width / kColumns;
    cloth.weights[i].mass += load * share / kGravity;
  }
  cloth.weight_norm = load * width / std::sqrt(kStride);
  DrapeState state = at_rest(place(sheet, [&](const Vec<2>& rest) {
    return Vec<3>(across * (rest[0] - width / 2), rest[1] - length, 0);
  }));
  const TriangleMesh nobody = make_nobody();
  const BodyCollider body(nobody.vertices, nobody.faces);
  const NewtonResult result = settle(cloth, {body, 0, {}, {1e-6, 300, 0.01}}, state);
  EXPECT_TRUE(result.has_converged) << result.residual;
  const double stretch = -state.x[3 * (kColumns / 2) + 1] / length;
  const double narrowing = (state.x[3 * kColumns] - state.x[0]) / width;
  const std::string name = garment::name_of(GetParam());
  report(name + ", hung: stretch", stretch, "");
  report(name + ", hung: error of the stretch", (stretch - along) / (along - 1), "");
  report(name + ", hung: error of the narrowing", (narrowing - across) / (1 - across), "");
  EXPECT_NEAR(stretch, along, kTolerance * (along - 1));
  EXPECT_NEAR(narrowing, across, kTolerance * (1 - across));
}

INSTANTIATE_TEST_SUITE_P(Isotropic, Law,
                         testing::Values(garment::MembraneModel::kStVenantKirchhoff,
                                         garment::MembraneModel::kNeoHookean));

// Measured cloth where its tables speak for themselves: S = 2 k G of the row at rest for a trace of
// strain, of the row of its direction at a stretch of 1/6.
class Table : public testing::TestWithParam<const char*> {};

void expect_row(const std::string& name, double measured, double expected) {
  report(name + ": error of the stress", measured / expected - 1, "");
  EXPECT_NEAR(measured, expected, kTolerance * expected) << name;
}

TEST_P(Table, IsWhatTheClothPullsWith) {
  const std::string name = GetParam();
  const garment::Fabric fabric = shipped(name);
  const auto& k = fabric.tables->stretching;
  const auto green = [](double stretch) { return (stretch * stretch - 1) / 2; };
  const double stretch = 7.0 / 6, trace = 1 + 1e-4;
  // P = F S: the stretch comes out again.
  expect_row(name + ", weft at rest",
             measured_stress(fabric, Vec<2>(trace, 1).asDiagonal())(0, 0) / trace,
             2 * k[0][0] * green(trace));
  expect_row(name + ", warp at rest",
             measured_stress(fabric, Vec<2>(1, trace).asDiagonal())(1, 1) / trace,
             2 * k[0][2] * green(trace));
  expect_row(name + ", weft at 1/6",
             measured_stress(fabric, Vec<2>(stretch, 1).asDiagonal())(0, 0) / stretch,
             2 * k[1][0] * green(stretch));
  expect_row(name + ", warp at 1/6",
             measured_stress(fabric, Vec<2>(1, stretch).asDiagonal())(1, 1) / stretch,
             2 * k[5][2] * green(stretch));
  // Turned by half the angle each way: pure shear of the frame, G_01 = sin(angle)/2.
  const double angle = 2e-4;
  Mat<2> shear;
  shear << std::cos(angle / 2), std::sin(angle / 2), std::sin(angle / 2), std::cos(angle / 2);
  expect_row(name + ", shear at rest", measured_stress(fabric, shear)(0, 1),
             2 * k[0][3] * std::sin(angle) / 2);
}

INSTANTIATE_TEST_SUITE_P(Shipped, Table,
                         testing::Values("gray_interlock", "black_denim", "royal_target"));

}  // namespace
}  // namespace pleat::sim
