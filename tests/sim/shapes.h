// Cloth and bodies that several tests use.
#pragma once

#include <cmath>
#include <string>

#include "core/random.h"
#include "tests/core/shapes.h"

namespace pleat::sim {

struct Sheet {
  Points2 rest;  // m, the panel's plane
  Faces faces;
  Eigen::VectorXd x;  // m, world
};

// A level square of `size` metres around the axis y; diagonals alternate, so that it is its own
// mirror image where the number of cells is even.
inline Sheet make_sheet(double size, int cells, double height) {
  const int side = cells + 1;
  const double h = size / cells;
  Sheet sheet;
  sheet.rest.resize(side * side, 2);
  sheet.x.resize(3 * side * side);
  sheet.faces = grid_faces(cells, cells, [](int i, int j) { return (i + j) % 2 != 0; });
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const int v = j * side + i;
      sheet.rest.row(v) << i * h - size / 2, j * h - size / 2;
      sheet.x.segment<3>(3 * v) << sheet.rest(v, 0), height, -sheet.rest(v, 1);
    }
  return sheet;
}

inline void shake(Eigen::VectorXd& x, double size, const std::string& name) {
  RandomStream random(5, name);
  for (double& coordinate : x) coordinate += size * random.normal();
}

// Closed and smooth, with hills and hollows: `height` is theirs as a share of the radius.
inline double bumpy_radius(const Vec<3>& unit, double radius, double height) {
  return radius * (1 + height * std::sin(5 * unit.x() + 1) * std::sin(6 * unit.y()) *
                           std::cos(4 * unit.z()));
}
inline TriangleMesh make_bumpy_ball(int levels, double radius, double height) {
  TriangleMesh ball = make_sphere(levels);
  for (int v = 0; v < ball.vertices.rows(); ++v)
    ball.vertices.row(v) *= bumpy_radius(ball.vertices.row(v).transpose(), radius, height);
  return ball;
}

inline TriangleMesh join(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh both;
  both.vertices.resize(a.vertices.rows() + b.vertices.rows(), 3);
  both.vertices << a.vertices, b.vertices;
  both.faces.resize(a.faces.rows() + b.faces.rows(), 3);
  both.faces << a.faces, b.faces.array() + static_cast<int>(a.vertices.rows());
  return both;
}

}  // namespace pleat::sim
