#include "core/mesh_quality.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/error.h"
#include "tests/core/input_error.h"
#include "tests/core/shapes.h"

namespace pleat {
namespace {

struct Sheet {
  Points2 rest;
  Faces faces;
};

Sheet make_sheet(int cells) {
  Sheet sheet;
  sheet.rest.resize((cells + 1) * (cells + 1), 2);
  for (int v = 0; v < sheet.rest.rows(); ++v) {
    sheet.rest.row(v) << v % (cells + 1), v / (cells + 1);
  }
  sheet.faces.resize(2 * cells * cells, 3);
  for (int c = 0; c < cells * cells; ++c) {
    const int corner = c % cells + (cells + 1) * (c / cells), above = corner + cells + 1;
    sheet.faces.row(2 * c) << corner, corner + 1, above + 1;
    sheet.faces.row(2 * c + 1) << corner, above + 1, above;
  }
  return sheet;
}

Points3 deform(const Points2& rest, const Eigen::Matrix<double, 3, 2>& gradient) {
  return rest * gradient.transpose();
}

TEST(Strain, OfARigidMotionIsNothing) {
  const Sheet sheet = make_sheet(5);
  const Mat<3> rotation = Eigen::AngleAxisd(1.1, Vec<3>(1, 2, 3).normalized()).toRotationMatrix();
  Points3 vertices = deform(sheet.rest, rotation.leftCols<2>());
  vertices.rowwise() += Eigen::RowVector3d(4, 5, 6);
  const Strain result = strain(vertices, sheet.faces, sheet.rest, sheet.faces);
  EXPECT_LT(result.max, 1e-14);
  EXPECT_LT(result.percentile_95, 1e-14);
}

TEST(Strain, IsTheLargerPrincipalStretch) {
  const Sheet sheet = make_sheet(3);
  // Stretches 1.25 and 0.5 along axes turned in the plane, then turned in space.
  const Mat<2> turn = Eigen::Rotation2Dd(0.3).toRotationMatrix();
  const Mat<2> stretch = turn * Vec<2>(1.25, 0.5).asDiagonal() * turn.transpose();
  const Mat<3> rotation = Eigen::AngleAxisd(-0.7, Vec<3>(3, -2, 1).normalized()).toRotationMatrix();
  const Points3 vertices = deform(sheet.rest, rotation.leftCols<2>() * stretch);
  const Strain result = strain(vertices, sheet.faces, sheet.rest, sheet.faces);
  EXPECT_NEAR(result.max, 0.25, 1e-14);
  EXPECT_NEAR(result.percentile_95, 0.25, 1e-14);
}

TEST(Strain, OfShearIsItsPrincipalStretch) {
  const Sheet sheet = make_sheet(2);
  Eigen::Matrix<double, 3, 2> shear;
  shear << 1, 0.5, 0, 1, 0, 0;
  // Larger singular value of [1 g; 0 1]: (g + sqrt(g^2 + 4)) / 2.
  const Strain result = strain(deform(sheet.rest, shear), sheet.faces, sheet.rest, sheet.faces);
  EXPECT_NEAR(result.max, 0.5 * (0.5 + std::sqrt(4.25)) - 1, 1e-14);
}

TEST(Strain, DoesNotCountCompression) {
  const Sheet sheet = make_sheet(2);
  const Points3 vertices = deform(sheet.rest, 0.5 * Eigen::Matrix<double, 3, 2>::Identity());
  EXPECT_EQ(strain(vertices, sheet.faces, sheet.rest, sheet.faces).max, 0);
}

TEST(Strain, PercentileLeavesOutTheRareFaces) {
  // 21 separate triangles, stretched by 0, 1, ... 20 percent: position 0.95 * 20 is the 19th.
  Points2 rest(63, 2);
  Points3 vertices = Points3::Zero(63, 3);
  Faces faces(21, 3);
  for (int f = 0; f < 21; ++f) {
    rest.middleRows(3 * f, 3) << 0, 0, 1, 0, 0, 1;
    const double s = 1 + 0.01 * ((f * 8) % 21);  // in mixed order
    vertices(3 * f + 1, 0) = s;
    vertices(3 * f + 2, 1) = s;
    faces.row(f) << 3 * f, 3 * f + 1, 3 * f + 2;
  }
  const Strain result = strain(vertices, faces, rest, faces);
  EXPECT_NEAR(result.max, 0.20, 1e-14);
  EXPECT_NEAR(result.percentile_95, 0.19, 1e-14);
}

TEST(Strain, NamesARestFaceWithoutArea) {
  Sheet sheet = make_sheet(2);
  sheet.rest.row(1) = sheet.rest.row(0);
  const Points3 vertices = Points3::Zero(9, 3);
  EXPECT_INPUT_ERROR(strain(vertices, sheet.faces, sheet.rest, sheet.faces), "face 0");
}

// Of the box [0,1]^3: the exact answer.
double box_distance(const Vec<3>& p) {
  const Vec<3> outside = (-p).cwiseMax(p - Vec<3>::Ones());
  const double beyond = outside.cwiseMax(0).norm();
  return beyond > 0 ? beyond : outside.maxCoeff();
}

// Around a cube nearly all directions lead to a corner or an edge, where one face's normal would
// lie.
TEST(SignedDistances, AreRightAroundTheCornersAndEdgesOfACube) {
  const TriangleMesh cube = make_cube();
  const SurfaceTree tree(cube.vertices, cube.faces);
  std::vector<Vec<3>> list;
  for (const double near : {1e-9, 1e-3, 0.2}) {
    for (int v = 0; v < 8; ++v) {
      const Vec<3> corner = cube.vertices.row(v);
      for (int k = 0; k < 26; ++k) {
        const int direction = k < 13 ? k : k + 1;  // all of the 3 x 3 x 3 but the middle
        list.push_back(corner +
                       near * Vec<3>(direction % 3 - 1, direction / 3 % 3 - 1, direction / 9 - 1));
      }
    }
    for (int axis = 0; axis < 3; ++axis) {  // around the middles of the edges
      for (int turn = 0; turn < 16; ++turn) {
        for (int edge = 0; edge < 4; ++edge) {
          Vec<3> p = Vec<3>::Constant(0.37);
          const double angle = (turn + 0.5) * M_PI / 8;
          p[(axis + 1) % 3] = edge % 2 + near * std::cos(angle);
          p[(axis + 2) % 3] = edge / 2 + near * std::sin(angle);
          list.push_back(p);
        }
      }
    }
  }
  Points3 points(list.size(), 3);
  for (size_t k = 0; k < list.size(); ++k) points.row(k) = list[k].transpose();
  const Eigen::VectorXd distances = signed_distances(tree, points, 1);
  for (size_t k = 0; k < list.size(); ++k) {
    EXPECT_NEAR(distances[k], box_distance(list[k]), 1e-15) << list[k].transpose();
  }
}

TEST(SignedDistances, AreZeroOnTheSurface) {
  const TriangleMesh cube = make_cube();
  const SurfaceTree tree(cube.vertices, cube.faces);
  EXPECT_EQ(signed_distances(tree, cube.vertices, 1).cwiseAbs().maxCoeff(), 0);
}

TEST(SignedDistances, AgreeWithWindingNumbersOnADentedSphere) {
  TriangleMesh mesh = make_sphere(3);
  for (int v = 0; v < mesh.vertices.rows(); ++v) {
    mesh.vertices.row(v) *= 1 + 0.35 * std::sin(7 * mesh.vertices(v, 0)) *
                                    std::cos(5 * mesh.vertices(v, 1) + mesh.vertices(v, 2));
  }
  const SurfaceTree tree(mesh.vertices, mesh.faces);
  RandomStream random(1, "points");
  Points3 points(2000, 3);
  for (int k = 0; k < points.rows(); ++k) points.row(k) = random_point(random, 1.4).transpose();
  const Eigen::VectorXd distances = signed_distances(tree, points, 10);
  const Eigen::VectorXd numbers = winding_numbers(tree, points);
  int inside = 0;
  for (int k = 0; k < points.rows(); ++k) {
    EXPECT_EQ(distances[k]<0, numbers[k]> 0.5) << points.row(k);
    const ClosestPoint closest = tree.closest(points.row(k), 10);
    EXPECT_NEAR(std::abs(distances[k]), std::sqrt(closest.squared_distance), 1e-15);
    inside += numbers[k] > 0.5;
  }
  EXPECT_GT(inside, 200);
}

TEST(SignedDistances, BeyondTheLimitAreTheLimitOutsideAndExactInside) {
  const TriangleMesh cube = make_cube();
  const SurfaceTree tree(cube.vertices, cube.faces);
  Points3 points(5, 3);
  points << 0.5, 0.5, 0.5, 0.5, 0.5, 3, 0.5, 0.5, 1.05, 0.5, 0.5, 0.95, -9, 0.5, 0.5;
  const Vec<5> expected = (Vec<5>() << -0.5, 0.1, 0.05, -0.05, 0.1).finished();
  EXPECT_LT((signed_distances(tree, points, 0.1) - expected).cwiseAbs().maxCoeff(), 1e-15);
}

}  // namespace
}  // namespace pleat
