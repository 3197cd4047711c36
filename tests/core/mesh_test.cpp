#include "core/mesh.h"

#include <gtest/gtest.h>

#include "tests/core/input_error.h"
#include "tests/core/shapes.h"

namespace pleat {
namespace {

TEST(Topology, OfACubeIsWatertight) {
  const Topology result = topology(make_cube().faces, 8);
  EXPECT_TRUE(result.is_watertight());
  EXPECT_EQ(result.components, 1);
  EXPECT_EQ(result.euler_characteristic, 2);
}

TEST(Topology, CountsTheBoundaryOfAnOpenCube) {
  const Faces faces = make_cube().faces.topRows(10);
  const Topology result = topology(faces, 8);
  EXPECT_EQ(result.boundary_edges, 4);
  EXPECT_EQ(result.nonmanifold_edges, 0);
  EXPECT_EQ(result.misoriented_edges, 0);
  EXPECT_EQ(result.euler_characteristic, 1);
  EXPECT_FALSE(result.is_watertight());
}

TEST(Topology, CountsEdgesOfThreeFaces) {
  Faces faces(3, 3);
  faces << 0, 1, 2, 1, 0, 3, 0, 1, 4;
  const Topology result = topology(faces, 5);
  EXPECT_EQ(result.nonmanifold_edges, 1);
  EXPECT_EQ(result.boundary_edges, 6);
  EXPECT_INPUT_ERROR(edges(faces), "vertices 0 and 1", "3 faces");
}

TEST(Topology, CountsEdgesOfAFlippedFace) {
  Faces faces = make_cube().faces;
  std::swap(faces(4, 0), faces(4, 1));
  EXPECT_EQ(topology(faces, 8).misoriented_edges, 3);
}

TEST(Topology, CountsComponentsWithoutUnusedVertices) {
  Faces faces(24, 3);
  faces.topRows(12) = make_cube().faces;
  faces.bottomRows(12) = make_cube().faces.array() + 9;
  const Topology result = topology(faces, 17 + 3);
  EXPECT_EQ(result.components, 2);
  EXPECT_EQ(result.euler_characteristic, 4);
}

TEST(Edges, KnowTheirFacesAndOppositeVertices) {
  Faces faces(2, 3);
  faces << 0, 1, 2, 2, 1, 3;
  const std::vector<Edge> list = edges(faces);
  ASSERT_EQ(list.size(), 5u);
  EXPECT_EQ(list[0].vertices, (std::array<int, 2>{0, 1}));
  EXPECT_EQ(list[0].faces, (std::array<int, 2>{0, -1}));
  EXPECT_EQ(list[0].opposite, (std::array<int, 2>{2, -1}));
  EXPECT_EQ(list[2].vertices, (std::array<int, 2>{1, 2}));
  EXPECT_EQ(list[2].faces, (std::array<int, 2>{0, 1}));
  EXPECT_EQ(list[2].opposite, (std::array<int, 2>{0, 3}));
}

// Each corner of a cube has three sides at right angles, however they are cut into triangles.
TEST(VertexNormals, OfACubePointAlongItsDiagonals) {
  TriangleMesh cube = make_cube();
  cube.vertices.conservativeResize(9, 3);
  cube.vertices.row(8).setConstant(7);  // used by no face
  const Points3 normals = vertex_normals(cube.vertices, cube.faces);
  for (int v = 0; v < 8; ++v) {
    const Vec<3> expected = (cube.vertices.row(v).array() - 0.5).matrix().transpose().normalized();
    EXPECT_LT((normals.row(v).transpose() - expected).norm(), 1e-15);
  }
  EXPECT_EQ(normals.row(8).norm(), 0);
}

TEST(FaceNormals, AndAreasOfACube) {
  const TriangleMesh cube = make_cube();
  const Points3 normals = face_normals(cube.vertices, cube.faces);
  EXPECT_EQ(normals.row(0), Eigen::RowVector3d(0, 0, -1));
  EXPECT_EQ(normals.row(11), Eigen::RowVector3d(1, 0, 0));
  EXPECT_EQ(face_areas(cube.vertices, cube.faces), Eigen::VectorXd::Constant(12, 0.5));
}

TEST(Subdivide, KeepsShapeTopologyAndUv) {
  TriangleMesh mesh = make_cube();
  mesh.uv.resize(4, 2);  // every face its own corner of one square
  mesh.uv << 0, 0, 1, 0, 1, 1, 0, 1;
  mesh.uv_faces.resize(12, 3);
  for (int f = 0; f < 12; ++f) mesh.uv_faces.row(f) << 0, 1, f % 2 ? 2 : 3;
  const TriangleMesh fine = subdivide(mesh);
  ASSERT_EQ(fine.faces.rows(), 48);
  EXPECT_EQ(fine.vertices.topRows(8), mesh.vertices);
  EXPECT_TRUE(topology(fine.faces, fine.vertices.rows()).is_watertight());
  EXPECT_EQ(topology(fine.faces, fine.vertices.rows()).euler_characteristic, 2);
  EXPECT_DOUBLE_EQ(face_areas(fine.vertices, fine.faces).sum(), 6);
  const Points3 normals = face_normals(fine.vertices, fine.faces);
  const Points3 old_normals = face_normals(mesh.vertices, mesh.faces);
  double uv_area = 0;
  for (int f = 0; f < 48; ++f) {
    EXPECT_EQ(normals.row(f), old_normals.row(f / 4));
    const Eigen::RowVector2d a = fine.uv.row(fine.uv_faces(f, 0));
    const Eigen::RowVector2d u = fine.uv.row(fine.uv_faces(f, 1)) - a;
    const Eigen::RowVector2d w = fine.uv.row(fine.uv_faces(f, 2)) - a;
    uv_area += 0.5 * (u[0] * w[1] - u[1] * w[0]);
  }
  EXPECT_DOUBLE_EQ(uv_area, 12 * 0.5);
}

}  // namespace
}  // namespace pleat
