#include "sim/drape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/proximity.h"
#include "tests/sim/dressed_ball.h"

namespace pleat::sim {
namespace {

// Cloth over a ball of 15 cm, and its drape.
struct Draped {
  TriangleMesh ball = make_sphere(4, 0.15);
  BodyCollider body{ball.vertices, ball.faces};
  Faces faces;
  Cloth cloth;
  DrapeState state;
  NewtonResult result;

  Draped(const Faces& faces, const Points2& rest, const Eigen::VectorXd& x,
         const std::vector<int>& pins = {})
      : faces(faces), cloth(make_cloth(faces, faces, rest, rest.rows(), {})) {
    state.x = x;
    state.anchors.resize(rest.rows());
    if (!pins.empty()) cloth.is_pinned.assign(rest.rows(), 0);
    for (const int v : pins) cloth.is_pinned[v] = 1;
    result = settle(state);
  }
  ContactSearch search(const Eigen::VectorXd& x) const {
    return {faces, cloth.area, x, body, {}, 0.5};
  }
  NewtonResult settle(DrapeState& from) const {
    ContactSearch contacts = search(from.x);
    Cholesky factor(cloth.bending_hessian);
    NewtonConfig solver;
    solver.max_iterations = 3000;  // from far away
    return drape(cloth, contacts, solver, factor, from);
  }
  // Of the forces at rest, found anew.
  double residual() const {
    ContactSearch contacts = search(state.x);
    contacts.prepare(state.x, Eigen::VectorXd::Zero(state.x.size()));
    std::vector<Anchor> anchors = state.anchors;
    const Region all = whole(cloth);
    System system;
    assemble(cloth, all, contacts.touching(all.vertices, state.x, anchors),
             contacts.barriers(contacts.pairs_at(all.place), state.x, Order::kGradient), state.x,
             Order::kGradient, system);
    return system.gradient.norm() / cloth.weight_norm;
  }
  double height(int v) const { return state.x[3 * v + 1]; }
};

void expect_free_of_intersections(const Draped& d) {
  const SurfaceTree cloth(Eigen::Map<const Points3>(d.state.x.data(), d.cloth.vertex_count, 3),
                          d.faces);
  EXPECT_TRUE(intersecting_faces(cloth, d.body.tree()).empty());
  EXPECT_TRUE(self_intersecting_faces(cloth).empty());
}

void expect_equilibrium(const Draped& d) {
  EXPECT_TRUE(d.result.has_converged);
  EXPECT_TRUE(d.result.is_stable);
  EXPECT_LE(d.result.residual, 1e-3);
}

void expect_settled(const Draped& d) {
  DrapeState again = d.state;
  const NewtonResult result = d.settle(again);
  EXPECT_TRUE(result.has_converged);
  double farthest = 0;
  for (int v = 0; v < d.cloth.vertex_count; ++v)
    farthest = std::max(farthest, (again.x - d.state.x).segment<3>(3 * v).norm());
  EXPECT_LE(farthest, 1e-5);
}

Draped drape_square_over_ball(int cells) {
  const Sheet square = make_sheet(0.5, cells, 0.155);
  return {square.faces, square.rest, square.x};
}
const Draped& square_over_ball(int cells) {
  static const Draped coarse = drape_square_over_ball(12), fine = drape_square_over_ball(16);
  return cells == 12 ? coarse : fine;
}

TEST(Drape, SquareSettlesOverABall) {
  for (const int cells : {12, 16}) {
    SCOPED_TRACE(cells);
    const Draped& d = square_over_ball(cells);
    expect_equilibrium(d);
    expect_free_of_intersections(d);
    double lowest = 1, closest = 1;
    for (int v = 0; v < d.cloth.vertex_count; ++v) {
      lowest = std::min(lowest, d.height(v));
      closest = std::min(closest, d.state.x.segment<3>(3 * v).norm());
    }
    EXPECT_LT(lowest, 0);      // the corners hang
    EXPECT_GT(closest, 0.15);  // the smooth surface is that of the ball itself
    EXPECT_LT(closest, 0.15 + ContactConfig{}.distance_m);
  }
}

// Anchors of what slid move behind it to the slip limit, where friction pulls as before.
TEST(Drape, SettledAnchorsLeaveTheEquilibrium) {
  for (const int cells : {12, 16}) EXPECT_LE(square_over_ball(cells).residual(), 1.1e-3) << cells;
}

TEST(Drape, SettlingAgainMovesNothing) {
  for (const int cells : {12, 16}) expect_settled(square_over_ball(cells));
}

TEST(Drape, IsTheSameBitForBit) {
  const Draped &a = square_over_ball(12), b = drape_square_over_ball(12);
  EXPECT_TRUE(a.state.x == b.state.x);
  EXPECT_EQ(a.result.iterations, b.result.iterations);
}

// A body that moved, with its cloth: the drape starts where the last one ended, and stays.
TEST(Drape, GoesWithTheBody) {
  const Draped& d = square_over_ball(12);
  const Vec<3> way(0.02, 0.01, -0.03);
  const Eigen::VectorXd ways = way.replicate(d.cloth.vertex_count, 1);
  DrapeState moved = d.state;
  moved.x += ways;
  Points3 there = d.ball.vertices;
  BodyCollider body(there, d.ball.faces);
  ContactSearch contacts(d.faces, d.cloth.area, d.state.x, body, {}, 0.5);
  there.rowwise() += way.transpose();
  body.move_to(there);
  contacts.forget();
  Cholesky factor(d.cloth.bending_hessian);
  const NewtonResult result = drape(d.cloth, contacts, NewtonConfig{}, factor, moved);
  EXPECT_TRUE(result.has_converged);
  EXPECT_LE((moved.x - ways - d.state.x).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(Drape, SaysThatForcesAreNotFinite) {
  const Draped& d = square_over_ball(12);
  Cloth cloth = d.cloth;
  cloth.membrane_law.mu = std::numeric_limits<double>::infinity();
  DrapeState state = d.state;
  BodyCollider body(d.ball.vertices, d.ball.faces);
  ContactSearch contacts(d.faces, cloth.area, state.x, body, {}, 0.5);
  Cholesky factor(cloth.bending_hessian);
  EXPECT_THROW(drape(cloth, contacts, NewtonConfig{}, factor, state), SolverError);
}

// Held at a corner, far from the body, its centre of mass comes to lie under the pin.
TEST(Drape, PinnedAtACornerHangs) {
  const Sheet square = make_sheet(0.2, 10, 1);
  Eigen::VectorXd x = square.x;
  shake(x, 1e-4, "hang");  // out of the plane in which it would balance
  const Draped d(square.faces, square.rest, x, {0});
  expect_equilibrium(d);
  expect_free_of_intersections(d);
  expect_settled(d);
  const Vec<3> pin = d.state.x.head<3>();
  EXPECT_LE((pin - x.head<3>()).norm(), 1e-7);
  Vec<3> centre = Vec<3>::Zero();
  double highest = -1, lowest = 2, mass = 0;
  for (int v = 0; v < d.cloth.vertex_count; ++v) {
    highest = std::max(highest, d.height(v));
    lowest = std::min(lowest, d.height(v));
    centre += d.cloth.weights[v].mass * d.state.x.segment<3>(3 * v);
    mass += d.cloth.weights[v].mass;
  }
  centre /= mass;
  // 1e-3 of the weights' norm is left, on arms of 10 cm: well below a millimetre.
  EXPECT_LE(Vec<2>(centre.x() - pin.x(), centre.z() - pin.z()).norm(), 1e-3);
  EXPECT_LT(centre.y(), pin.y() - 0.1);
  EXPECT_NEAR(highest, pin.y(), 1e-3);
  EXPECT_NEAR(lowest, pin.y() - 0.2 * std::sqrt(2), 0.02);  // its diagonal, stretched by its weight
}

// A second square, askew, held where it lies on top: layers slide on one another without friction.
TEST(Drape, SecondLayerRestsOnTheFirst) {
  const Sheet square = make_sheet(0.24, 8, 0);
  const int count = static_cast<int>(square.rest.rows());
  Points2 rest(2 * count, 2);
  rest << square.rest, square.rest;
  Faces faces(2 * square.faces.rows(), 3);
  faces << square.faces, square.faces.array() + count;
  Points3 positions(2 * count, 3);
  positions << lay_on_ball(square, 0.153, 0), lay_on_ball(square, 0.156, 0.4);
  const Draped d(faces, rest, Eigen::Map<Eigen::VectorXd>(positions.data(), positions.size()),
                 {count + count / 2});
  expect_equilibrium(d);
  expect_free_of_intersections(d);
  // Seen from the ball's centre, the upper lies over the lower wherever both are.
  const SurfaceTree lower(Eigen::Map<const Points3>(d.state.x.data(), count, 3), square.faces);
  int both = 0;
  for (int v = 0; v < count; ++v) {
    const Vec<3> place = d.state.x.segment<3>(3 * (count + v));
    const ClosestPoint below = lower.closest(place, 4 * ContactConfig{}.layer_distance_m);
    if (below.face < 0 || below.barycentric.minCoeff() < 0.01) continue;  // beside it
    ++both;
    EXPECT_GT(place.norm(), below.point.norm()) << v;
  }
  EXPECT_GT(both, count / 4);
}

// What does not come to rest says so.
TEST(Drape, TooFewIterationsDoNotConverge) {
  const Draped& d = square_over_ball(12);
  DrapeState state{make_sheet(0.5, 12, 0.155).x, std::vector<Anchor>(d.cloth.vertex_count)};
  NewtonConfig solver;
  solver.max_iterations = 2;
  ContactSearch contacts = d.search(state.x);
  Cholesky factor(d.cloth.bending_hessian);
  const NewtonResult result = drape(d.cloth, contacts, solver, factor, state);
  EXPECT_FALSE(result.has_converged);
  EXPECT_EQ(result.iterations, 2);
  EXPECT_GT(result.residual, solver.residual);
}

}  // namespace
}  // namespace pleat::sim
