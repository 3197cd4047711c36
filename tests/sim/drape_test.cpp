#include "sim/drape.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/shapes.h"

namespace pleat::sim {
namespace {

struct Sheet {
  Points2 rest;
  Faces faces;
  Eigen::VectorXd x;
};

// A square sheet in the plane y = height; diagonals alternate, so that it is mirror-symmetric.
Sheet sheet(double size, int cells, double height) {
  const int side = cells + 1;
  const double h = size / cells;
  Sheet s;
  s.rest.resize(side * side, 2);
  s.x.resize(3 * side * side);
  s.faces.resize(2 * cells * cells, 3);
  for (int j = 0, f = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const int v = j * side + i;
      s.rest.row(v) << i * h - size / 2, j * h - size / 2;
      s.x.segment<3>(3 * v) << s.rest(v, 0), height, -s.rest(v, 1);
      if (i == cells || j == cells) continue;
      if ((i + j) % 2) {
        s.faces.row(f++) << v, v + 1, v + side + 1;
        s.faces.row(f++) << v, v + side + 1, v + side;
      } else {
        s.faces.row(f++) << v, v + 1, v + side;
        s.faces.row(f++) << v + 1, v + side + 1, v + side;
      }
    }
  return s;
}

struct Draped {
  Cloth cloth;
  DrapeState state;
  NewtonResult result;
};

Draped drape_over_sphere(int cells) {
  const TriangleMesh ball = make_sphere(4, 0.15);
  const BodyCollider collider(ball.vertices, ball.faces);
  const Sheet square = sheet(0.5, cells, 0.155);
  const garment::Fabric fabric;
  Draped d{make_cloth(square.faces, square.faces, square.rest, square.rest.rows(), fabric), {}, {}};
  d.state.x = square.x;
  d.state.anchors.resize(square.rest.rows());
  Cholesky factor(d.cloth.bending_hessian);
  d.result = drape(d.cloth, collider, 0.5, ContactConfig{}, NewtonConfig{}, factor, d.state);
  return d;
}

TEST(Drape, SquareOverSphereSettlesOutside) {
  const Draped d = drape_over_sphere(24);
  EXPECT_TRUE(d.result.has_converged);
  EXPECT_LE(d.result.residual, 1e-3);
  double lowest = 1, closest = 1;
  for (int v = 0; v < d.cloth.vertex_count; ++v) {
    lowest = std::min(lowest, d.state.x[3 * v + 1]);
    closest = std::min(closest, d.state.x.segment<3>(3 * v).norm());
  }
  EXPECT_LT(lowest, 0.0);  // the corners hang
  EXPECT_GT(
      closest,
      0.149);  // the facetted ball lies 0.5 mm inside its sphere; the gap keeps the cloth off it
}

TEST(Drape, SettlingAgainMovesNothing) {
  const Draped d = drape_over_sphere(16);
  ASSERT_TRUE(d.result.has_converged);
  const TriangleMesh ball = make_sphere(4, 0.15);
  const BodyCollider collider(ball.vertices, ball.faces);
  DrapeState again = d.state;
  Cholesky factor(d.cloth.bending_hessian);
  const NewtonResult result =
      drape(d.cloth, collider, 0.5, ContactConfig{}, NewtonConfig{}, factor, again);
  EXPECT_TRUE(result.has_converged);
  EXPECT_LE((again.x - d.state.x).lpNorm<Eigen::Infinity>(), 1e-5);
}

TEST(Drape, IsTheSameBitForBit) {
  const Draped a = drape_over_sphere(12), b = drape_over_sphere(12);
  EXPECT_TRUE(a.state.x == b.state.x);
}

}  // namespace
}  // namespace pleat::sim
