// A square hung by two corners that are nearer to one another than they are in the cloth.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/validation/scene.h"

namespace pleat::sim {
namespace {

constexpr double kSize = 0.2;  // m; one of 0.3 m of denim folds to one side, where it rests better
constexpr int kCells = 24, kStride = kCells + 1;

struct Hung {
  Cloth cloth;
  DrapeState state;
  NewtonResult result;
  Points3 force;  // N
};

// Mirror-symmetric about x = 0, mesh and start.
Hung hang(const garment::Fabric& fabric, double residual) {
  const Sheet sheet = make_grid({kSize, kSize}, kCells, kCells, Diagonal::kAlternating);
  Hung hung{make_cloth(sheet, fabric), {}, {}, {}};
  pin(hung.cloth, [](int v) { return v == kCells * kStride || v == kStride * kStride - 1; });
  hung.state = at_rest(place(sheet, [](const Vec<2>& rest) {
    const double t = 2 * rest[0] / kSize - 1;
    return Vec<3>(0.9 * kSize / 2 * t, rest[1] - kSize, 0.3 * kSize * (1 - t * t) / 2);
  }));
  const TriangleMesh nobody = make_nobody();
  const BodyCollider body(nobody.vertices, nobody.faces);
  const Stage stage{body, 0, {}, {residual, 500, 0.01}};
  hung.result = settle(hung.cloth, stage, hung.state);
  hung.force = forces_on(hung.cloth, stage, hung.state);
  return hung;
}

class HungSquare : public testing::TestWithParam<const char*> {};

TEST_P(HungSquare, PinsCarryItsWeight) {
  const Hung hung = hang(shipped(GetParam()), 1e-7);
  EXPECT_TRUE(hung.result.has_converged) << hung.result.residual;
  const int left = kCells * kStride, right = kStride * kStride - 1;
  // What acts on a pin and is not balanced there is what the pin holds.
  const Vec<3> held = (hung.force.row(left) + hung.force.row(right)).transpose();
  const double weight = weight_of(hung.cloth);
  report(std::string(GetParam()) + ": weight", weight, "N");
  report("  error of what the pins carry", (held - Vec<3>(0, -weight, 0)).norm() / weight, "");
  EXPECT_LE((held - Vec<3>(0, -weight, 0)).norm(), 1e-6 * weight);
}

TEST_P(HungSquare, MirrorsItself) {
  const Hung hung = hang(shipped(GetParam()), 1e-6);
  const Points3 x = as_rows(hung.state.x);
  double worst = 0;
  for (int v = 0; v < hung.cloth.vertex_count; ++v) {
    const int mirrored = v - v % kStride + kCells - v % kStride;
    const Vec<3> other(-x(mirrored, 0), x(mirrored, 1), x(mirrored, 2));
    worst = std::max(worst, (x.row(v).transpose() - other).norm());
  }
  report(std::string(GetParam()) + ": worst difference of its halves", 1000 * worst, "mm");
  EXPECT_LE(worst, 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Shipped, HungSquare,
                         testing::Values("gray_interlock", "black_denim", "tango_red_jet_set"));

}  // namespace
}  // namespace pleat::sim
