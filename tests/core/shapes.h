// Small surfaces that several tests use.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <string>

#include "core/mesh.h"
#include "core/random.h"

namespace pleat {

// Unit cube, corner at the origin, outward. Vertex index = x + 2 y + 4 z.
inline TriangleMesh make_cube() {
  TriangleMesh mesh;
  mesh.vertices.resize(8, 3);
  for (int v = 0; v < 8; ++v) mesh.vertices.row(v) << (v & 1), (v >> 1 & 1), v >> 2;
  mesh.faces.resize(12, 3);
  mesh.faces << 0, 2, 3, 0, 3, 1,  // z = 0
      4, 5, 7, 4, 7, 6,            // z = 1
      0, 1, 5, 0, 5, 4,            // y = 0
      2, 6, 7, 2, 7, 3,            // y = 1
      0, 4, 6, 0, 6, 2,            // x = 0
      1, 3, 7, 1, 7, 5;            // x = 1
  return mesh;
}

// Octahedron subdivided `levels` times, corners on the sphere.
inline TriangleMesh make_sphere(int levels, double radius = 1) {
  TriangleMesh mesh;
  mesh.vertices.resize(6, 3);
  mesh.vertices << 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1;
  mesh.faces.resize(8, 3);
  mesh.faces << 0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5;
  for (int k = 0; k < levels; ++k) mesh = subdivide(mesh);
  mesh.vertices.rowwise().normalize();
  mesh.vertices *= radius;
  return mesh;
}

inline Vec<3> random_point(RandomStream& random, double extent = 1) {
  const double x = random.uniform(), y = random.uniform(), z = random.uniform();
  return extent * Vec<3>(2 * x - 1, 2 * y - 1, 2 * z - 1);
}

// Unconnected triangles of about `size` in [-1, 1]^3.
inline TriangleMesh make_soup(int count, double size, const std::string& name) {
  RandomStream random(1, name);
  TriangleMesh mesh;
  mesh.vertices.resize(3 * count, 3);
  mesh.faces.resize(count, 3);
  for (int f = 0; f < count; ++f) {
    const Vec<3> centre = random_point(random);
    for (int k = 0; k < 3; ++k) {
      mesh.vertices.row(3 * f + k) = (centre + random_point(random, size)).transpose();
      mesh.faces(f, k) = 3 * f + k;
    }
  }
  return mesh;
}

// Triangles of a grid of columns x rows cells whose vertices run row by row. rises(column, row): whether a
// cell's diagonal goes from its first corner to the opposite one.
template <typename Rises>
Faces grid_faces(int columns, int rows, Rises rises) {
  const int stride = columns + 1;
  Faces faces(2 * columns * rows, 3);
  for (int j = 0, f = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const int v = j * stride + i;
      if (rises(i, j)) {
        faces.row(f++) << v, v + 1, v + stride + 1;
        faces.row(f++) << v, v + stride + 1, v + stride;
      } else {
        faces.row(f++) << v, v + 1, v + stride;
        faces.row(f++) << v + 1, v + stride + 1, v + stride;
      }
    }
  return faces;
}

}  // namespace pleat
