#include "core/mesh_file.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/core/input_error.h"
#include "tests/core/scratch.h"
#include "tests/core/shapes.h"

namespace pleat {
namespace {

// The corners of each face, whatever the numbering of vertices.
Eigen::MatrixXd corner_rows(const Points3& vertices, const Faces& faces) {
  Eigen::MatrixXd rows(faces.rows(), 9);
  for (int f = 0; f < faces.rows(); ++f) {
    for (int k = 0; k < 3; ++k) rows.block<1, 3>(f, 3 * k) = vertices.row(faces(f, k));
  }
  return rows;
}

TEST(MeshFile, ReadsBackItsObjWithUvSeams) {
  const Scratch scratch;
  TriangleMesh mesh = make_sphere(2);
  mesh.uv_faces.resize(mesh.faces.rows(), 3);  // every face its own island
  mesh.uv.resize(3 * mesh.faces.rows(), 2);
  RandomStream random(1, "uv");
  for (int k = 0; k < mesh.uv_faces.size(); ++k) {
    mesh.uv_faces.data()[k] = k;
    const double u = random.uniform(), v = random.uniform();
    mesh.uv.row(k) << u, v;
  }
  write_obj(scratch.path("a.obj"), mesh);
  const TriangleMesh back = read_mesh(scratch.path("a.obj"));
  ASSERT_EQ(back.faces.rows(), mesh.faces.rows());
  EXPECT_EQ(back.vertices.rows(), mesh.vertices.rows());  // merged over the UV seams
  EXPECT_TRUE(topology(back.faces, back.vertices.rows()).is_watertight());
  EXPECT_LT((corner_rows(back.vertices, back.faces) - corner_rows(mesh.vertices, mesh.faces))
                .cwiseAbs()
                .maxCoeff(),
            1e-7);  // assimp keeps float32
  ASSERT_EQ(back.uv_faces.rows(), mesh.faces.rows());
  for (int f = 0; f < mesh.faces.rows(); ++f) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_LT((back.uv.row(back.uv_faces(f, k)) - mesh.uv.row(mesh.uv_faces(f, k))).norm(), 1e-6);
    }
  }
}

TEST(MeshFile, WritesObjWithoutUv) {
  const Scratch scratch;
  TriangleMesh mesh;
  mesh.vertices = Points3::Zero(3, 3);
  mesh.vertices(1, 0) = 1.0 / 3;
  mesh.vertices(2, 1) = 2;
  mesh.faces.resize(1, 3);
  mesh.faces << 0, 1, 2;
  write_obj(scratch.path("a.obj"), mesh);
  EXPECT_EQ(read_bytes(scratch.path("a.obj")), "v 0 0 0\nv 0.333333333 0 0\nv 0 2 0\nf 1 2 3\n");
  EXPECT_EQ(read_mesh(scratch.path("a.obj")).uv.rows(), 0);
}

TEST(MeshFile, TriangulatesPolygonsAndLeavesOutLines) {
  const Scratch scratch;
  write_bytes(scratch.path("a.obj"),
              "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 5 5 5\nf 1 2 3 4\nl 1 5\n");
  const TriangleMesh mesh = read_mesh(scratch.path("a.obj"));
  EXPECT_EQ(mesh.vertices.rows(), 4);
  EXPECT_EQ(mesh.faces.rows(), 2);
  EXPECT_DOUBLE_EQ(face_areas(mesh.vertices, mesh.faces).sum(), 1);
}

TEST(MeshFile, NamesFilesThatItCannotRead) {
  const Scratch scratch;
  EXPECT_INPUT_ERROR(read_mesh(scratch.path("none.obj")), "none.obj", "no such file");
  write_bytes(scratch.path("a.xyz"), "nonsense");
  EXPECT_INPUT_ERROR(read_mesh(scratch.path("a.xyz")), "a.xyz");
  write_bytes(scratch.path("points.obj"), "v 0 0 0\nv 1 0 0\n");
  EXPECT_INPUT_ERROR(read_mesh(scratch.path("points.obj")), "points.obj");
  write_bytes(scratch.path("nan.obj"), "v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n");
  EXPECT_INPUT_ERROR(read_mesh(scratch.path("nan.obj")), "nan.obj", "finite");
}

}  // namespace
}  // namespace pleat
