#include "sim/forces/membrane_law.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"
#include "measured_fabrics.h"

namespace pleat::sim {
namespace {

constexpr double kTableStrain = 13.0 / 72;  // (7/6)^2 = 1 + 2 * 13/72

MembraneLaw isotropic(garment::MembraneModel model) {
  garment::Fabric fabric;
  fabric.membrane = model;
  return make_membrane_law(fabric);
}
const MembraneLaw kStvk = isotropic(garment::MembraneModel::kStVenantKirchhoff);
const MembraneLaw kNeoHookean = isotropic(garment::MembraneModel::kNeoHookean);

std::vector<std::pair<std::string, MembraneLaw>> all_laws() {
  std::vector<std::pair<std::string, MembraneLaw>> laws = {{"stvk", kStvk},
                                                           {"neo_hookean", kNeoHookean}};
  for (const auto& [name, fabric] : measured_fabrics())
    laws.emplace_back(name, make_membrane_law(fabric));
  return laws;
}

// Principal strains e_1, e_2, the first at `angle` from axis 0, as (G_00, G_11, 2 G_01).
Vec<3> strain(double e_1, double e_2, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * c * e_1 + s * s * e_2, s * s * e_1 + c * c * e_2, 2 * c * s * (e_1 - e_2)};
}

// From nearly rest to beyond every table, in tension, in compression and mixed.
Vec<3> random_strain(RandomStream& random) {
  const double size = std::pow(10, -3 + 2.5 * random.uniform());
  const double e_1 = size * (2 * random.uniform() - 1);
  double e_2 = size * (2 * random.uniform() - 1);
  if (std::abs(e_1 - e_2) < 0.05 * size) e_2 = -e_1;  // without a direction: tested below
  return strain(e_1, e_2, M_PI * random.uniform());
}

double largest_stiffness(const MembraneLaw& law) {
  double largest = law.lambda + 2 * law.mu;
  for (const Vec<4>& row : law.rows) largest = std::max(largest, 2 * row.maxCoeff());
  return largest;
}

// Central differences of step h err by h^2 times a third derivative, which is a stiffness over the
// difference of the principal strains, and by rounding over h: 1e-5 of the strain keeps both small.
TEST(MembraneLaw, StressAndTangentAreDerivatives) {
  for (const auto& [name, law] : all_laws()) {
    RandomStream random(3, name);
    const double stiffness = largest_stiffness(law);
    for (int i = 0; i < 200; ++i) {
      const Vec<3> g = random_strain(random);
      const double h = 1e-5 * g.norm();
      const MembraneResponse at = membrane_response(law, g, Order::kHessian);
      for (int k = 0; k < 3; ++k) {
        const Vec<3> step = h * Vec<3>::Unit(k);
        const MembraneResponse up = membrane_response(law, g + step, Order::kGradient);
        const MembraneResponse down = membrane_response(law, g - step, Order::kGradient);
        EXPECT_NEAR((up.energy - down.energy) / (2 * h), at.stress[k], 1e-6 * stiffness * g.norm())
            << name << " at " << g.transpose();
        EXPECT_LE(((up.stress - down.stress) / (2 * h) - at.tangent.col(k)).norm(),
                  1e-5 * stiffness)
            << name << " at " << g.transpose();
      }
    }
  }
}

TEST(MembraneLaw, EnergyIsLeastAtRest) {
  for (const auto& [name, law] : all_laws()) {
    RandomStream random(4, name);
    const MembraneResponse rest = membrane_response(law, Vec<3>::Zero(), Order::kHessian);
    EXPECT_EQ(rest.energy, 0) << name;
    EXPECT_EQ(rest.stress, Vec<3>(0, 0, 0)) << name;
    for (int i = 0; i < 1000; ++i)
      EXPECT_GT(membrane_response(law, random_strain(random), Order::kValue).energy, 0) << name;
  }
}

// Nowhere a jump of the stress: two strains that differ by 1e-9 differ in stress by no more than
// the bounded tangent between them allows.
TEST(MembraneLaw, StressIsContinuousAndTangentBounded) {
  for (const auto& [name, law] : all_laws()) {
    RandomStream random(5, name);
    const double bound = 30 * largest_stiffness(law);
    std::vector<Vec<3>> strains;
    for (double e : {0.001, 0.02, 0.09, kTableStrain, 0.3}) {
      strains.push_back(strain(e, e, 0));  // no direction
      strains.push_back(strain(-e, -e, 0));
      for (int i = 0; i < 5; ++i) {
        strains.push_back(strain(e, 0, i * M_PI / 8));  // between one and two tensile strains
        strains.push_back(strain(0, -e, i * M_PI / 8));
      }
    }
    for (const Vec<3>& g : strains)
      for (int i = 0; i < 10; ++i) {
        const Vec<3> step = 1e-9 * Vec<3>(random.normal(), random.normal(), random.normal());
        const Vec<3> before = membrane_response(law, g - step, Order::kGradient).stress;
        const MembraneResponse after = membrane_response(law, g + step, Order::kHessian);
        EXPECT_LE((after.stress - before).norm(), bound * 2 * step.norm())
            << name << " at " << g.transpose();
        EXPECT_LE(after.tangent.norm(), bound) << name << " at " << g.transpose();
      }
  }
}

TEST(MembraneLaw, IsotropicLawsAgreeForSmallStrains) {
  RandomStream random(6, "small");
  for (int i = 0; i < 20; ++i) {
    const Vec<3> g = 1e-5 * random_strain(random);
    const Vec<3> stress = membrane_response(kStvk, g, Order::kGradient).stress;
    // They differ by terms quadratic in the strain.
    EXPECT_LE((membrane_response(kNeoHookean, g, Order::kGradient).stress - stress).norm(),
              10 * largest_stiffness(kStvk) * g.squaredNorm());
  }
}

TEST(MembraneLaw, NeoHookeanResistsBeingCrushed) {
  const auto energy = [](double stretch) {
    const double green = 0.5 * (stretch * stretch - 1);
    return membrane_response(kNeoHookean, Vec<3>(green, 0, 0), Order::kGradient);
  };
  EXPECT_LT(energy(0.01).stress[0], 10 * energy(0.1).stress[0]);
  EXPECT_GT(energy(1e-6).energy, energy(0.01).energy);
  EXPECT_TRUE(std::isinf(energy(0).energy));
}

// What the table says: S = 2 (k_uu G_00 + k_uv G_11, k_uv G_00 + k_vv G_11, k_s G_01).
Vec<3> table_stress(const Vec<4>& k, const Vec<3>& g) {
  return {2 * (k[0] * g[0] + k[1] * g[1]), 2 * (k[1] * g[0] + k[2] * g[1]), k[3] * g[2]};
}

// The stress that does work along the path from rest is the table's: exactly at its strain and
// beyond, and half-way, where the rounding at either end balances.
TEST(MembraneLaw, TablesGiveTheirStressAlongStraightPaths) {
  for (const auto& [name, fabric] : measured_fabrics()) {
    const MembraneLaw law = make_membrane_law(fabric);
    for (int direction = 0; direction < 5; ++direction)
      for (double ratio : {0.0, -0.3, -1.0}) {  // of the smaller to the larger strain
        const Vec<3> path = strain(1, ratio, direction * M_PI / 8);
        for (const auto& [size, share] :
             {std::pair(0.5 * kTableStrain, 0.5), std::pair(kTableStrain, 1.0),
              std::pair(2 * kTableStrain, 1.0)}) {
          const Vec<3> g = size * path;
          const Vec<4> k = (1 - share) * law.rows[0] + share * law.rows[1 + direction];
          const double expected = table_stress(k, g).dot(path);
          EXPECT_NEAR(membrane_response(law, g, Order::kGradient).stress.dot(path), expected,
                      1e-10 * expected)
              << name << " " << direction << " " << size;
        }
      }
  }
}

// Between rest and the table's strain stiffness rises on a straight line but for its rounded ends;
// a width of 0.1 moves it by at most 0.05/0.9 of the way.
TEST(MembraneLaw, TablesAreReadLinearlyInStrain) {
  for (const auto& [name, fabric] : measured_fabrics()) {
    const MembraneLaw law = make_membrane_law(fabric);
    for (double share = 0.05; share < 1.2; share += 0.05) {
      const Vec<3> g(0, share * kTableStrain, 0);
      const double from = law.rows[0][2], to = law.rows[5][2];
      const double read = membrane_response(law, g, Order::kGradient).stress[1] / (2 * g[1]);
      EXPECT_NEAR(read, from + std::min(share, 1.0) * (to - from), 0.056 * std::abs(to - from))
          << name << " " << share;
    }
  }
}

TEST(MembraneLaw, CompressionIsReadAtRest) {
  for (const auto& [name, fabric] : measured_fabrics()) {
    const MembraneLaw law = make_membrane_law(fabric);
    const Vec<3> g = strain(-0.02, -0.15, 0.4);
    const Vec<3> expected = table_stress(law.rows[0], g);
    EXPECT_LE((membrane_response(law, g, Order::kGradient).stress - expected).norm(),
              1e-13 * expected.norm())
        << name;
  }
}

// Negative coupling and shear count as none; coupling stays at or below the geometric mean.
TEST(MembraneLaw, RowsOfTablesAreMadePositive) {
  garment::Fabric fabric;
  fabric.tables = garment::FabricTables{};
  for (auto& row : fabric.tables->stretching) row = {10, 5, 40, 8};
  fabric.tables->stretching[1] = {10, -5, 40, -8};
  fabric.tables->stretching[2] = {10, 50, 40, 8};
  const MembraneLaw law = make_membrane_law(fabric);
  EXPECT_EQ(law.rows[0], Vec<4>(10, 5, 40, 8));
  EXPECT_EQ(law.rows[1], Vec<4>(10, 0, 40, 0));
  EXPECT_EQ(law.rows[2], Vec<4>(10, 20, 40, 8));
}

TEST(MembraneLaw, WarpAndWeftDiffer) {
  for (const std::string name : {"black_denim", "gray_interlock", "tango_red_jet_set"}) {
    const MembraneLaw law = make_membrane_law(measured_fabric(name));
    const double weft = membrane_response(law, Vec<3>(0.05, 0, 0), Order::kGradient).stress[0];
    const double warp = membrane_response(law, Vec<3>(0, 0.05, 0), Order::kGradient).stress[1];
    EXPECT_GT(warp, 1.5 * weft) << name;
  }
}

}  // namespace
}  // namespace pleat::sim
