// A scene turned about the vertical drapes as before, turned. Where cloth buckles, rounding may tip
// it to another side, and friction remembers the way: such a drape must stay where it is when it is
// turned after it has settled.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/core/shapes.h"
#include "tests/validation/scene.h"

namespace pleat::sim {
namespace {

constexpr double kTolerance = 1e-4;  // m

const Mat<3> kTurn = Eigen::AngleAxisd(0.65, Vec<3>::UnitY()).toRotationMatrix();

Eigen::VectorXd turned(const Eigen::VectorXd& x) {
  Eigen::VectorXd result(x.size());
  for (Eigen::Index v = 0; v < x.size() / 3; ++v)
    result.segment<3>(3 * v) = kTurn * x.segment<3>(3 * v);
  return result;
}

double worst_difference(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return as_rows(a - b).rowwise().norm().maxCoeff();
}

TEST(Turn, OfACantilever) {
  const Sheet sheet = make_lattice(0.004, 20, 10);
  Cloth cloth = make_cloth(sheet, garment::Fabric{});
  pin(cloth, [&](int v) { return sheet.rest(v, 0) < 0.005; });
  const TriangleMesh nobody = make_nobody();
  const BodyCollider body(nobody.vertices, nobody.faces);
  const Stage stage{body, 0, {}, {1e-4, 500, 0.01}};
  DrapeState straight =
      at_rest(place(sheet, [](const Vec<2>& rest) { return Vec<3>(rest[0], 0, -rest[1]); }));
  DrapeState other = at_rest(turned(straight.x));
  EXPECT_TRUE(settle(cloth, stage, straight).has_converged);
  EXPECT_TRUE(settle(cloth, stage, other).has_converged);
  const double difference = worst_difference(turned(straight.x), other.x);
  report("cantilever: worst difference", 1000 * difference, "mm");
  EXPECT_LE(difference, kTolerance);
}

// So stiff that it takes one shape: softer cloth buckles, and rounding may tip a fold to either
// side.
garment::Fabric stiff() {
  garment::Fabric fabric;
  fabric.density_kg_per_m2 = 0.3;
  fabric.youngs_modulus_N_per_m = 1000;
  fabric.bending_N_m = 5e-4;
  return fabric;
}

// Held in the middle, or it would rock on the ball, and laid down askew.
struct OverBall {
  TriangleMesh ball = make_sphere(4, 0.15), turned_ball;
  Sheet sheet = make_grid({0.4, 0.4}, 24, 24, Diagonal::kAlternating);
  Cloth cloth;
  DrapeState start;

  explicit OverBall(const garment::Fabric& fabric) : cloth(make_cloth(sheet, fabric)) {
    turned_ball = {(ball.vertices * kTurn.transpose()).eval(), ball.faces, {}, {}};
    const Vec<2> middle(0.2, 0.2);
    pin(cloth, [&](int v) { return (sheet.rest.row(v).transpose() - middle).norm() < 0.02; });
    start = at_rest(place(sheet, [&](const Vec<2>& rest) {
      const Vec<2> off = rest - middle;
      return Vec<3>(off[0], 0.155 + 0.01 * off[0] + 0.2 * off[0] * off[1], -off[1]);
    }));
  }
};
constexpr NewtonConfig kSolver{1e-4, 500, 0.01};

// Without friction, which remembers the way.
TEST(Turn, OfASquareOverASphere) {
  OverBall scene(stiff());
  const BodyCollider body(scene.ball.vertices, scene.ball.faces);
  const BodyCollider turned_body(scene.turned_ball.vertices, scene.turned_ball.faces);
  DrapeState straight = scene.start, other = at_rest(turned(scene.start.x));
  EXPECT_TRUE(settle(scene.cloth, {body, 0, {}, kSolver}, straight).has_converged);
  EXPECT_TRUE(settle(scene.cloth, {turned_body, 0, {}, kSolver}, other).has_converged);
  const double difference = worst_difference(turned(straight.x), other.x);
  report("square over a sphere, no friction: worst difference", 1000 * difference, "mm");
  EXPECT_LE(difference, kTolerance);
}

// With friction, what has settled and is turned with its anchors stays.
TEST(Turn, OfADrapeMovesNothing) {
  OverBall scene(shipped("black_denim"));
  const BodyCollider body(scene.ball.vertices, scene.ball.faces);
  const BodyCollider turned_body(scene.turned_ball.vertices, scene.turned_ball.faces);
  DrapeState settled = scene.start;
  EXPECT_TRUE(settle(scene.cloth, {body, 0.4, {}, kSolver}, settled).has_converged);
  DrapeState again{turned(settled.x), settled.anchors};
  EXPECT_TRUE(settle(scene.cloth, {turned_body, 0.4, {}, kSolver}, again).has_converged);
  const double moved = worst_difference(turned(settled.x), again.x);
  report("square over a sphere, the drape turned: worst move", 1000 * moved, "mm");
  EXPECT_LE(moved, kTolerance);
}

}  // namespace
}  // namespace pleat::sim
