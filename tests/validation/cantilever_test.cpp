// A strip clamped level at one end against the heavy elastica: an inextensible rod whose moment is
// that of the fabric's law, bent by its own weight.
//   dM/ds = -w (L - s) cos(theta),  dtheta/ds = kappa(M),  theta(0) = 0,  M(L) = 0
// theta: how far the rod points below the level; w: weight a unit of length.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/validation/scene.h"

namespace pleat::sim {
namespace {

constexpr double kTolerance = 0.02;  // of the droop: what a mesh of 12 to 24 rows can tell

// Curvature under a moment, both a unit of width; the inverse of the law by bisection.
using Curvature = std::function<double(double moment)>;

struct Tip {
  double reach, droop;  // m, from the clamp
};

// The rod from a tip that points `angle` down, back to the clamp: classical Runge-Kutta method.
struct Rod {
  double angle;  // theta at the clamp
  Tip tip;
};
Rod run_back(double weight, double length, double angle, const Curvature& curvature) {
  constexpr int kSteps = 400;
  const double h = length / kSteps;
  using State = Vec<4>;  // theta, M, reach, droop
  const auto slope = [&](double from_tip, const State& y) {
    return State(-curvature(y[1]), weight * from_tip * std::cos(y[0]), std::cos(y[0]),
                 std::sin(y[0]));
  };
  State y(angle, 0, 0, 0);
  for (int i = 0; i < kSteps; ++i) {
    const double r = i * h;
    const State a = slope(r, y), b = slope(r + h / 2, y + h / 2 * a),
                c = slope(r + h / 2, y + h / 2 * b), d = slope(r + h, y + h * c);
    y += h / 6 * (a + 2 * b + 2 * c + d);
  }
  return {y[0], {y[2], y[3]}};
}

// Shoots from the tip: the angle there for which the clamp is level.
Tip elastica(double weight, double length, const Curvature& curvature) {
  double low = 0, high = M_PI / 2;
  for (int i = 0; i < 50; ++i) {
    const double middle = (low + high) / 2;
    (run_back(weight, length, middle, curvature).angle < 0 ? low : high) = middle;
  }
  return run_back(weight, length, low, curvature).tip;
}

TEST(Elastica, IsTheBeamOfSmallDroop) {
  const double weight = 0.01, length = 0.1, rigidity = 1e-3;  // w L^3 / B = 0.01
  const Tip tip = elastica(weight, length, [=](double moment) { return moment / rigidity; });
  EXPECT_NEAR(tip.droop, weight * std::pow(length, 4) / (8 * rigidity), 1e-4 * tip.droop);
}

// Strip along axis 0, its first row of cells clamped. A row of edges turns half a cell on either
// side of it, so the clamp is in the middle of those cells, exact to second order.
struct Strip {
  Sheet sheet;
  double cell;  // m, along the strip
};
Strip grid_strip(double length, double width, int cells, Diagonal diagonal) {
  const double cell = length / (cells + 0.5);
  return {make_grid({(cells + 1) * cell, width}, cells + 1, std::lround(width / cell), diagonal),
          cell};
}
Strip lattice_strip(double length, double width, int cells) {
  const double cell = length / (cells + 0.5), edge = cell * 2 / std::sqrt(3);
  return {make_lattice(edge, cells + 1, std::lround(width / edge)), cell};
}

// turn: the strip's axis 0 is panel axis 1 instead. side -1: the face that was up is down.
Tip droop(const Strip& strip, const garment::Fabric& fabric, bool turn, int side) {
  Sheet cut = strip.sheet;
  if (turn) {
    cut.rest.col(0).swap(cut.rest.col(1));
    cut.faces.col(1).swap(cut.faces.col(2));
  }
  const double clamp = 1.5 * strip.cell;
  Cloth cloth = make_cloth(cut, fabric);
  pin(cloth, [&](int v) { return strip.sheet.rest(v, 0) < clamp; });
  DrapeState state = at_rest(place(strip.sheet, [&](const Vec<2>& rest) {
    return Vec<3>(rest[0] - strip.cell / 2, 0, -side * rest[1]);
  }));
  const TriangleMesh nobody = make_nobody();
  const BodyCollider body(nobody.vertices, nobody.faces);
  ContactConfig contact;
  contact.layer_distance_m = 1e-4;  // below the finest mesh's own spacing
  const Stage stage{body, 0, contact, {1e-4, 500, 0.01}};
  const NewtonResult result = settle(cloth, stage, state);
  EXPECT_TRUE(result.has_converged) << result.residual;
  const double end = strip.sheet.rest.col(0).maxCoeff() - 0.1 * strip.cell;
  Tip tip{0, 0};
  int count = 0;
  for (int v = 0; v < cloth.vertex_count; ++v) {
    if (strip.sheet.rest(v, 0) < end) continue;
    tip.reach += state.x[3 * v];
    tip.droop -= state.x[3 * v + 1];
    ++count;
  }
  return {tip.reach / count, tip.droop / count};
}

void expect_elastica(const std::string& name, const Tip& measured, const Tip& expected) {
  report(name + ", droop / elastica's", measured.droop / expected.droop, "");
  EXPECT_NEAR(measured.droop, expected.droop, kTolerance * expected.droop) << name;
  EXPECT_NEAR(measured.reach, expected.reach, kTolerance * expected.droop) << name;
}

// Stretches little, so that the rod may be inextensible and the strip cannot curl across.
garment::Fabric sheeting() {
  garment::Fabric fabric;
  fabric.youngs_modulus_N_per_m = 1000;
  return fabric;
}

struct Length {
  double relative;  // to (B / w)^(1/3)
  bool on_grids;    // on grids of right-angled triangles too
};
class CantileverOf : public testing::TestWithParam<Length> {};

// Grids whose diagonals all run one way couple bending to twist: where the bend is too gentle to
// make the strip a cylinder, it twists and droops 3 to 5 % more. Panels are cut from lattices.
TEST_P(CantileverOf, DroopsLikeTheElastica) {
  const garment::Fabric fabric = sheeting();
  const double weight = fabric.density_kg_per_m2 * kGravity, width = 0.04;
  const double length = GetParam().relative * std::cbrt(fabric.bending_N_m / weight);
  const Tip expected =
      elastica(weight, length, [&](double moment) { return moment / fabric.bending_N_m; });
  report("elastica's droop over the length", expected.droop / length, "");
  for (const int cells : {12, 24})
    for (const int side : {1, -1}) {
      const std::string name = std::to_string(cells) + (side > 0 ? " rows, up" : " rows, down");
      expect_elastica(name + ", lattice",
                      droop(lattice_strip(length, width, cells), fabric, false, side), expected);
      if (!GetParam().on_grids) continue;
      expect_elastica(
          name + ", rising diagonals",
          droop(grid_strip(length, width, cells, Diagonal::kRising), fabric, false, side),
          expected);
      expect_elastica(
          name + ", falling diagonals",
          droop(grid_strip(length, width, cells, Diagonal::kFalling), fabric, false, side),
          expected);
    }
}

INSTANTIATE_TEST_SUITE_P(Lengths, CantileverOf,
                         testing::Values(Length{2, false}, Length{3, false}, Length{4, true}));

TEST(Cantilever, OfMeasuredClothFollowsItsTable) {
  for (const char* name : {"black_denim", "gray_interlock"}) {
    const garment::Fabric fabric = shipped(name);
    const BendingLaw law = make_bending_law(fabric);
    const double weight = fabric.density_kg_per_m2 * kGravity, width = 0.04, length = 0.04;
    for (const bool turn : {false, true}) {
      // The strip along axis 0 folds along axis 1: the table's last row, else its first.
      const Vec<3> row = turn ? Vec<3>(1, 0, 0) : Vec<3>(0, 0, 1);
      const auto curvature = [&](double moment) {
        double low = 0, high = 1e4;
        for (int i = 0; i < 50; ++i) {
          const double middle = (low + high) / 2;
          const BendingResponse bent = measured_bending(law, row, middle);
          (bent.secant_rigidity * middle < moment ? low : high) = middle;
        }
        return low;
      };
      const Tip expected = elastica(weight, length, curvature);
      for (const int rows : {12, 24})
        for (const int side : {1, -1})
          expect_elastica(
              std::string(name) + (turn ? ", along v, " : ", along u, ") + std::to_string(rows) +
                  (side > 0 ? " rows, up" : " rows, down"),
              droop(lattice_strip(length, width, rows), fabric, turn, side), expected);
    }
  }
}

}  // namespace
}  // namespace pleat::sim
