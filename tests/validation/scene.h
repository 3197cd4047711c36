// Sheets, bodies and drapes that the physical checks share.
#pragma once

#include <functional>
#include <string>

#include "core/mesh.h"
#include "sim/drape.h"

namespace pleat::sim {

// Flat cloth in its panel's plane.
struct Sheet {
  Points2 rest;  // m
  Faces faces;   // counter-clockwise
};

enum class Diagonal { kRising, kFalling, kAlternating };

// Rectangle [0, size] of square-ish cells, each cut along a diagonal. Alternating diagonals on even
// counts are mirror-symmetric. Vertex (i, j) is j (columns + 1) + i.
Sheet make_grid(const Vec<2>& size, int columns, int rows, Diagonal diagonal);

// Equilateral lattice with edges of length `edge` along axis 1: rows of `count` and of count - 1
// edges, sqrt(3)/2 edge apart along axis 0, from 0 on.
Sheet make_lattice(double edge, int rows, int count);

// Positions stacked for the solver: place(rest) is where each vertex starts, m, world.
Eigen::VectorXd place(const Sheet& sheet, const std::function<Vec<3>(const Vec<2>&)>& where);
Points3 as_rows(const Eigen::VectorXd& stacked);

Cloth make_cloth(const Sheet& sheet, const garment::Fabric& fabric);
void pin(Cloth& cloth, const std::function<bool(int vertex)>& is_pinned);

// One of the fabrics that ship.
garment::Fabric shipped(const std::string& name);

// A tetrahedron too far away to matter, for cloth that meets nothing.
TriangleMesh make_nobody();
// Box with its corner at the origin, of evenly meshed faces whose edges are `edge` long or less.
TriangleMesh make_box(const Vec<3>& size, double edge);

// A cloth at a body: the numbers that a drape takes.
struct Stage {
  const BodyCollider& body;
  double friction = 0.4;
  ContactConfig contact = {};
  NewtonConfig solver = {};
};
DrapeState at_rest(const Eigen::VectorXd& x);
NewtonResult settle(const Cloth& cloth, const Stage& stage, DrapeState& state);

// Of all that acts on each vertex, pins left out: #V x 3, N.
Points3 forces_on(const Cloth& cloth, const Stage& stage, const DrapeState& state);
double weight_of(const Cloth& cloth);  // N

// One line of docs/validation.md.
void report(const std::string& what, double value, const std::string& unit);

}  // namespace pleat::sim
