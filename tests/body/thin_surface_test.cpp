#include "body/thin_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/mesh.h"
#include "tests/body/synthetic_body.h"

namespace pleat::body {
namespace {

TriangleMesh ellipsoid() {
  TriangleMesh mesh = box_mesh(4);
  for (int v = 0; v < mesh.vertices.rows(); ++v) {
    mesh.vertices.row(v) =
        mesh.vertices.row(v).normalized().cwiseProduct(Eigen::RowVector3d(0.3, 0.5, 0.2));
  }
  return mesh;
}

TEST(ThinSurface, ReachesItsTargetAndStaysClosed) {
  const TriangleMesh mesh = ellipsoid();
  const std::vector<char> all(static_cast<size_t>(mesh.vertices.rows()), 1);
  const Faces thin = thin_surface(mesh.vertices, mesh.faces, all, 600);
  EXPECT_LE(thin.rows(), 600);
  EXPECT_GE(thin.rows(), 598);
  EXPECT_TRUE(topology(thin, static_cast<int>(mesh.vertices.rows())).is_watertight());
  const auto volume = [&](const Faces& faces) {
    double sum = 0;
    for (int f = 0; f < faces.rows(); ++f) {
      Mat<3> corners;
      for (int c = 0; c < 3; ++c) corners.col(c) = mesh.vertices.row(faces(f, c));
      sum += corners.col(0).dot(corners.col(1).cross(corners.col(2))) / 6;
    }
    return sum;
  };
  EXPECT_NEAR(volume(thin), volume(mesh.faces),
              0.03 * volume(mesh.faces));  // inscribed, h^2 smaller
}

TEST(ThinSurface, KeepsWhatMayNotGo) {
  const TriangleMesh mesh = ellipsoid();
  std::vector<char> may_go(static_cast<size_t>(mesh.vertices.rows()));
  for (int v = 0; v < mesh.vertices.rows(); ++v) may_go[v] = mesh.vertices(v, 1) > 0.2;
  const Faces thin = thin_surface(mesh.vertices, mesh.faces, may_go, 4);
  EXPECT_TRUE(topology(thin, static_cast<int>(mesh.vertices.rows())).is_watertight());
  std::vector<std::array<int, 3>> left;
  for (int f = 0; f < thin.rows(); ++f) left.push_back({thin(f, 0), thin(f, 1), thin(f, 2)});
  int untouched = 0;
  for (int f = 0; f < mesh.faces.rows(); ++f) {
    if (may_go[mesh.faces(f, 0)] || may_go[mesh.faces(f, 1)] || may_go[mesh.faces(f, 2)]) continue;
    ++untouched;
    const std::array<int, 3> face = {mesh.faces(f, 0), mesh.faces(f, 1), mesh.faces(f, 2)};
    EXPECT_NE(std::find(left.begin(), left.end(), face), left.end());
  }
  EXPECT_GT(untouched, 100);
  EXPECT_LT(thin.rows(), mesh.faces.rows() - 200);
}

}  // namespace
}  // namespace pleat::body
