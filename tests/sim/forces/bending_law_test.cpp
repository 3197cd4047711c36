#include "sim/forces/bending_law.h"

#include <gtest/gtest.h>

#include "measured_fabrics.h"

namespace pleat::sim {
namespace {

BendingLaw law_of(const std::array<double, 5>& row) {
  garment::Fabric fabric;
  fabric.tables = garment::FabricTables{};
  fabric.tables->bending = {row, row, row};
  return make_bending_law(fabric);
}

double moment(const BendingLaw& law, const Vec<3>& weights, double c) {
  return c * measured_bending(law, weights, c).secant_rigidity;
}

const Vec<3> kFirst(1, 0, 0);

TEST(BendingLaw, EqualNumbersAreTheConstantLaw) {
  const BendingLaw law = law_of({4e-5, 4e-5, 4e-5, 4e-5, 4e-5});  // a plate's rigidity times 4
  for (double c : {0.0, 3.0, 10.0, 27.0, 40.0, 150.0}) {
    const BendingResponse bent = measured_bending(law, kFirst, c);
    EXPECT_NEAR(bent.energy, 0.5e-5 * c * c, 1e-13 * c * c);
    EXPECT_NEAR(bent.secant_rigidity, 1e-5, 1e-17);
    EXPECT_NEAR(bent.tangent_rigidity, 1e-5, 1e-17);
  }
}

TEST(BendingLaw, MomentRunsThroughTheTable) {
  const std::array<double, 5> row = {4e-5, 6e-5, 7e-5, 7e-5, 6.5e-5};
  const BendingLaw law = law_of(row);
  for (int i = 0; i < 5; ++i) {
    const double c = 10 * i;
    EXPECT_NEAR(measured_bending(law, kFirst, c).secant_rigidity, row[i] / 4, 1e-18) << i;
  }
  // Beyond: the last rigidity.
  EXPECT_NEAR(measured_bending(law, kFirst, 200).secant_rigidity, row[4] / 4, 1e-18);
}

// 30 * 8e-5 is more than 40 * 5e-5: a moment that fell would let a fold run away into one edge.
TEST(BendingLaw, MomentNeverFalls) {
  const BendingLaw law = law_of({8e-5, 8e-5, 8e-5, 8e-5, 5e-5});
  const double most = 30 * 8e-5 / 4;
  EXPECT_NEAR(moment(law, kFirst, 30), most, 1e-17);
  EXPECT_NEAR(moment(law, kFirst, 35), most, 1e-17);
  EXPECT_NEAR(moment(law, kFirst, 40), most, 1e-17);
  EXPECT_NEAR(moment(law, kFirst, 60), most + 20 * 5e-5 / 4, 1e-17);
}

// Central differences of step 1e-4 1/m: the energy's third derivative is below 1e-5 N m^2 at the
// largest, so that 1e-13 is left of the step, and 1e-12 of rounding.
TEST(BendingLaw, ShippedFabricsHaveConvexEnergyWithItsDerivatives) {
  for (const auto& [name, fabric] : measured_fabrics()) {
    const BendingLaw law = make_bending_law(fabric);
    for (const Vec<3>& weights : {Vec<3>(1, 0, 0), Vec<3>(0, 1, 0), Vec<3>(0, 0, 1),
                                  Vec<3>(0.3, 0.7, 0), Vec<3>(0.2, 0.3, 0.5)}) {
      double last = 0;
      for (double c = 0.37; c < 120; c += 0.731) {
        const double h = 1e-4;
        const BendingResponse at = measured_bending(law, weights, c);
        const double slope = (measured_bending(law, weights, c + h).energy -
                              measured_bending(law, weights, c - h).energy) /
                             (2 * h);
        EXPECT_NEAR(c * at.secant_rigidity, slope, 1e-6 * slope) << name << " " << c;
        EXPECT_NEAR(at.tangent_rigidity,
                    (moment(law, weights, c + h) - moment(law, weights, c - h)) / (2 * h), 1e-9)
            << name << " " << c;
        EXPECT_GE(at.tangent_rigidity, 0) << name << " " << c;
        EXPECT_GE(slope, last * (1 - 1e-9)) << name << " " << c;
        last = slope;
      }
    }
  }
}

TEST(BendingLaw, ShippedFabricsKeepTheirTablesUpToThirtyAMetre) {
  for (const auto& [name, fabric] : measured_fabrics()) {
    const BendingLaw law = make_bending_law(fabric);
    for (int row = 0; row < 3; ++row)
      for (int i = 1; i < 4; ++i) {
        const Vec<3> weights = Vec<3>::Unit(row);
        const double table = fabric.tables->bending[row][i] / 4;
        const double read = measured_bending(law, weights, 10 * i).secant_rigidity;
        EXPECT_NEAR(read, table, 1e-12 * table) << name << " " << row << " " << i;
      }
  }
}

}  // namespace
}  // namespace pleat::sim
