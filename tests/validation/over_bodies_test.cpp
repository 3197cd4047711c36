// A square over a sphere and over a table: nothing crosses, and what has settled stays.
// PLEAT_PICTURES names a folder for pictures of them.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "show/image.h"
#include "show/render.h"
#include "tests/core/shapes.h"
#include "tests/validation/judge.h"
#include "tests/validation/scene.h"

namespace pleat::sim {
namespace {

using judge::crossings;
using judge::self_crossings;

TEST(Judge, SeesWhatCrosses) {
  const TriangleMesh cube = make_cube();
  const Sheet sheet = make_grid({1, 1}, 3, 3, Diagonal::kRising);
  const auto at = [&](double height) {
    return as_rows(place(sheet, [=](const Vec<2>& rest) {
      return Vec<3>(rest[0] + 0.3, height, rest[1] + 0.4);
    }));
  };
  EXPECT_GT(crossings(at(0.9), sheet.faces, cube.vertices, cube.faces), 0);
  EXPECT_EQ(crossings(at(1.1), sheet.faces, cube.vertices, cube.faces), 0);
  Points3 folded = at(0);
  for (int v : {10, 11, 14}) folded(v, 1) += 1;
  folded.row(15) = folded.row(0) + Eigen::RowVector3d(0.2, -0.1, 0.1);  // a corner through it
  EXPECT_GT(self_crossings(folded, sheet.faces), 0);
  EXPECT_EQ(self_crossings(at(0), sheet.faces), 0);
}

enum class Support { kSphere, kTable };
struct Scene {
  Support support;
  const char* fabric;
};
class SquareOver : public testing::TestWithParam<Scene> {};

TriangleMesh make_support(Support support) {
  if (support == Support::kSphere) return make_sphere(4, 0.15);
  constexpr double kRound = 0.02;
  const Vec<3> size(0.24, 0.1, 0.24);
  TriangleMesh table = make_box(size, 0.012);
  for (Eigen::Index v = 0; v < table.vertices.rows(); ++v) {
    const Vec<3> corner = table.vertices.row(v).transpose();
    const Vec<3> inner = corner.cwiseMax(kRound).cwiseMin((size.array() - kRound).matrix());
    const Vec<3> out = corner - inner;
    if (out.norm() > 0)
      table.vertices.row(v) = (inner + kRound * out.normalized()).transpose();
  }
  table.vertices.rowwise() -= Eigen::RowVector3d(0.12, 0.1, 0.12);
  return table;
}

TEST_P(SquareOver, CrossesNothingAndStays) {
  const TriangleMesh support = make_support(GetParam().support);
  const BodyCollider body(support.vertices, support.faces);
  const Sheet sheet = make_grid({0.4, 0.4}, 28, 28, Diagonal::kAlternating);
  const Cloth cloth = make_cloth(sheet, shipped(GetParam().fabric));
  const double top = support.vertices.col(1).maxCoeff() + 0.005;
  DrapeState state = at_rest(place(sheet, [&](const Vec<2>& rest) {
    return Vec<3>(rest[0] - 0.2, top, 0.2 - rest[1]);
  }));
  const Stage stage{body, 0.4, {}, {1e-3, 1500, 0.01}};
  const NewtonResult first = settle(cloth, stage, state);
  EXPECT_TRUE(first.has_converged) << first.residual;

  DrapeState again = state;
  const NewtonResult second = settle(cloth, stage, again);
  const double moved = (as_rows(again.x) - as_rows(state.x)).rowwise().norm().maxCoeff();

  const Points3 x = as_rows(state.x);
  const std::string name = std::string(GetParam().fabric) +
                           (GetParam().support == Support::kSphere ? " over a sphere"
                                                                   : " over a table");
  report(name + ": iterations", first.iterations, "");
  report("  iterations of the second drape", second.iterations, "");
  report("  moved by it", 1000 * moved, "mm");
  report("  faces that cross the body, or one another",
         crossings(x, cloth.faces, support.vertices, support.faces) + self_crossings(x, cloth.faces), "");
  if (const char* folder = std::getenv("PLEAT_PICTURES")) {
    show::RenderConfig config;
    config.width = 320;
    config.height = 260;
    config.ground_height_m = x.col(1).minCoeff() - 0.002;
    show::Camera camera;
    camera.target = Vec<3>(0, (x.col(1).minCoeff() + x.col(1).maxCoeff()) / 2, 0);
    camera.eye = camera.target + Vec<3>(0.7, 0.8, 1.4);
    camera.orthographic_height_m = 0.36;
    const bool is_sphere = GetParam().support == Support::kSphere;
    show::write_png(std::string(folder) + (is_sphere ? "/over_sphere_" : "/over_table_") +
                        GetParam().fabric + ".png",
                    show::render({show::body_mesh(support.vertices, support.faces),
                                  show::cloth_mesh(x, cloth.faces)},
                                 camera, config));
  }
  EXPECT_TRUE(second.has_converged);
  EXPECT_LE(moved, 1e-5);
  EXPECT_EQ(crossings(x, cloth.faces, support.vertices, support.faces), 0);
  EXPECT_EQ(self_crossings(x, cloth.faces), 0);
  EXPECT_LT(x.col(1).minCoeff(), top - 0.05);  // it hangs
}

INSTANTIATE_TEST_SUITE_P(Supports, SquareOver,
                         testing::Values(Scene{Support::kSphere, "gray_interlock"},
                                         Scene{Support::kSphere, "black_denim"},
                                         Scene{Support::kTable, "gray_interlock"},
                                         Scene{Support::kTable, "black_denim"}));

}  // namespace
}  // namespace pleat::sim
