// Triangle meshes: what a surface is, and the quantities read off it.
#pragma once

#include <array>
#include <vector>

#include "core/types.h"

namespace pleat {

struct TriangleMesh {
  Points3 vertices;  // #V x 3, m
  Faces faces;       // #F x 3, counter-clockwise seen from outside
  Points2 uv;        // #T x 2 in [0,1]^2, v up; empty where the mesh has none
  Faces uv_faces;    // #F x 3, indices into uv; empty where the mesh has none
};

// An edge with the faces on its two sides.
struct Edge {
  std::array<int, 2> vertices;  // ascending
  std::array<int, 2> faces;     // second is -1 on the boundary
  std::array<int, 2>
      opposite;  // vertex of each face that is not on the edge; second is -1 on the boundary
};

// Sorted by vertices. Throws InputError where an edge has more than two faces.
std::vector<Edge> edges(const Faces& faces);

// Faces across each edge, from corner c to the next, one row a face; -1 where there is none. Of
// consistently oriented faces.
Faces face_neighbours(const Faces& faces);
// Vertices that share an edge with each vertex.
std::vector<std::vector<int>> vertex_neighbours(const Faces& faces, Eigen::Index vertex_count);

// Row of each vertex sums face normals weighted by corner angle, then unit length. Zero for an
// unused vertex.
Points3 vertex_normals(const Eigen::Ref<const Points3>& vertices, const Faces& faces);
// The same for the vertices that are asked for; the other rows stay.
void update_vertex_normals(const Eigen::Ref<const Points3>& vertices, const Faces& faces,
                           const std::vector<char>& is_asked, Points3& normals);
Points3 face_normals(const Eigen::Ref<const Points3>& vertices, const Faces& faces);  // unit length
Eigen::VectorXd face_areas(const Eigen::Ref<const Points3>& vertices, const Faces& faces);

// What a closed, consistently oriented surface must satisfy. Vertices that no face uses do not
// count.
struct Topology {
  int boundary_edges = 0;
  int nonmanifold_edges = 0;  // more than two faces
  int misoriented_edges = 0;  // both faces run along it the same way
  int components = 0;         // of faces joined through shared vertices
  int euler_characteristic = 0;
  bool is_watertight() const { return !boundary_edges && !nonmanifold_edges && !misoriented_edges; }
};
Topology topology(const Faces& faces, int vertex_count);

// Each triangle into four, positions and UVs at the edges' middles. Old vertices keep their
// indices.
TriangleMesh subdivide(const TriangleMesh& mesh);

}  // namespace pleat
