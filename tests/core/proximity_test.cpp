#include "core/proximity.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/exact_predicates.h"
#include "core/random.h"
#include "tests/core/shapes.h"

namespace pleat {
namespace {

using Pairs = std::vector<std::array<int, 2>>;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

std::array<Vec<3>, 3> corners(const TriangleMesh& mesh, int f) {
  return {mesh.vertices.row(mesh.faces(f, 0)), mesh.vertices.row(mesh.faces(f, 1)),
          mesh.vertices.row(mesh.faces(f, 2))};
}

// The independent judge: CGAL with exact predicates.
bool cgal_meet(const std::array<Vec<3>, 3>& s, const std::array<Vec<3>, 3>& t) {
  const auto triangle = [](const std::array<Vec<3>, 3>& x) {
    const auto point = [](const Vec<3>& p) { return Kernel::Point_3(p[0], p[1], p[2]); };
    return Kernel::Triangle_3(point(x[0]), point(x[1]), point(x[2]));
  };
  return CGAL::do_intersect(triangle(s), triangle(t));
}

double cgal_squared_distance(const Vec<3>& p, const std::array<Vec<3>, 3>& t) {
  const auto point = [](const Vec<3>& x) { return Kernel::Point_3(x[0], x[1], x[2]); };
  return CGAL::squared_distance(point(p),
                                Kernel::Triangle_3(point(t[0]), point(t[1]), point(t[2])));
}

double brute_force_squared_distance(const Vec<3>& p, const TriangleMesh& mesh,
                                    const std::vector<char>& is_allowed = {}) {
  double best = std::numeric_limits<double>::infinity();
  for (int f = 0; f < mesh.faces.rows(); ++f) {
    if (!is_allowed.empty() && !is_allowed[f]) continue;
    best = std::min(best, cgal_squared_distance(p, corners(mesh, f)));
  }
  return best;
}

void expect_closest(const SurfaceTree& tree, const TriangleMesh& mesh, const Vec<3>& query) {
  const ClosestPoint found = tree.closest(query, 100);
  const double expected = brute_force_squared_distance(query, mesh);
  ASSERT_GE(found.face, 0);
  EXPECT_NEAR(found.squared_distance, expected, 1e-14 + 1e-12 * expected);
  EXPECT_NEAR(found.barycentric.sum(), 1, 1e-15);
  EXPECT_GE(found.barycentric.minCoeff(), 0);
  const std::array<Vec<3>, 3> t = corners(mesh, found.face);
  const Vec<3> point =
      found.barycentric[0] * t[0] + found.barycentric[1] * t[1] + found.barycentric[2] * t[2];
  EXPECT_LT((point - found.point).norm(), 1e-14);
  EXPECT_NEAR((query - found.point).squaredNorm(), found.squared_distance, 1e-14);
}

TEST(SurfaceTree, FindsTheClosestPointOfASoup) {
  const TriangleMesh mesh = make_soup(300, 0.3, "soup");
  const SurfaceTree tree(mesh.vertices, mesh.faces);
  RandomStream random(1, "queries");
  for (int q = 0; q < 300; ++q) expect_closest(tree, mesh, random_point(random, 1.5));
}

TEST(SurfaceTree, FindsTheClosestPointAfterARefit) {
  TriangleMesh mesh = make_sphere(3);
  SurfaceTree tree(mesh.vertices, mesh.faces);
  for (int v = 0; v < mesh.vertices.rows(); ++v) {
    mesh.vertices.row(v) *= 1 + 0.3 * std::sin(5 * mesh.vertices(v, 0));
    mesh.vertices(v, 1) += 3;
  }
  tree.refit(mesh.vertices);
  RandomStream random(1, "queries");
  for (int q = 0; q < 100; ++q) {
    expect_closest(tree, mesh, Vec<3>(0, 3, 0) + random_point(random, 1.5));
  }
}

TEST(SurfaceTree, FindsNothingBeyondTheDistanceAskedFor) {
  const TriangleMesh mesh = make_cube();
  const SurfaceTree tree(mesh.vertices, mesh.faces);
  EXPECT_EQ(tree.closest({0.5, 0.5, 1.25}, 0.2).face, -1);
  EXPECT_GE(tree.closest({0.5, 0.5, 1.25}, 0.3).face, 0);
  EXPECT_GE(tree.closest({0.5, 0.5, 1.25}, std::numeric_limits<double>::infinity()).face, 0);
}

TEST(SurfaceTree, LeavesOutFacesThatAreNotAllowed) {
  const TriangleMesh mesh = make_soup(200, 0.3, "soup");
  const SurfaceTree tree(mesh.vertices, mesh.faces);
  RandomStream random(1, "allowed");
  std::vector<char> is_allowed(200);
  for (char& allowed : is_allowed) allowed = random.below(2) == 1;
  for (int q = 0; q < 100; ++q) {
    const Vec<3> query = random_point(random);
    const ClosestPoint found = tree.closest(query, 100, is_allowed);
    ASSERT_GE(found.face, 0);
    EXPECT_TRUE(is_allowed[found.face]);
    EXPECT_NEAR(found.squared_distance, brute_force_squared_distance(query, mesh, is_allowed),
                1e-14);
  }
}

TEST(SurfaceTree, OfNoFacesFindsNothing) {
  const SurfaceTree tree(Points3::Zero(3, 3), Faces(0, 3));
  EXPECT_EQ(tree.closest({0, 0, 0}, 100).face, -1);
  EXPECT_TRUE(self_intersecting_faces(tree).empty());
}

TEST(ClosestOnTriangle, HandlesTrianglesWithoutArea) {
  const Vec<3> a(0, 0, 0), b(1, 0, 0), m(0.25, 0, 0), p(0.5, 1, 0);
  const auto distance = [&p](const Vec<3>& u, const Vec<3>& v, const Vec<3>& w) {
    const Vec<3> weights = closest_on_triangle(p, u, v, w);
    return (weights[0] * u + weights[1] * v + weights[2] * w - p).norm();
  };
  EXPECT_DOUBLE_EQ(distance(a, b, m), 1);
  EXPECT_DOUBLE_EQ(distance(a, a, b), 1);
  EXPECT_DOUBLE_EQ(distance(a, b, b), 1);
  EXPECT_DOUBLE_EQ(distance(b, b, b), std::sqrt(1.25));
}

TEST(ClosestOnTriangle, GivesExactZerosOnCornersAndEdges) {
  const Vec<3> a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  EXPECT_EQ(closest_on_triangle({-1, -2, 3}, a, b, c), Vec<3>(1, 0, 0));
  EXPECT_EQ(closest_on_triangle({0.25, -1, 3}, a, b, c), Vec<3>(0.75, 0.25, 0));
  EXPECT_EQ(closest_on_triangle({-1, 0.25, 3}, a, b, c), Vec<3>(0.75, 0, 0.25));
  EXPECT_EQ(closest_on_triangle({1, 1, 3}, a, b, c), Vec<3>(0, 0.5, 0.5));
}

// Corners on a coarse grid make coplanar, touching and degenerate pairs common.
TEST(TrianglesMeet, AgreesWithCgalOnAGrid) {
  RandomStream random(1, "grid");
  int meeting = 0, judged = 0;
  while (judged < 20000) {
    std::array<std::array<Vec<3>, 3>, 2> pair;
    bool has_area = true;
    for (auto& triangle : pair) {
      for (Vec<3>& corner : triangle) {
        for (int k = 0; k < 3; ++k) corner[k] = 0.1 * static_cast<double>(random.below(4));
      }
      const Vec<3> u = triangle[1] - triangle[0], w = triangle[2] - triangle[0];
      has_area &= u.cross(w).norm() > 1e-9;
    }
    if (!has_area) continue;  // CGAL expects triangles
    ++judged;
    const bool expected = cgal_meet(pair[0], pair[1]);
    ASSERT_EQ(triangles_meet(pair[0], pair[1]), expected);
    ASSERT_EQ(triangles_meet(pair[1], pair[0]), expected);
    meeting += expected;
  }
  EXPECT_GT(meeting, 4000);
  EXPECT_LT(meeting, 16000);
}

// A corner moved by single units in the last place off the other's plane, far from the origin.
TEST(TrianglesMeet, DecidesByTheLastBit) {
  const std::array<Vec<3>, 3> floor = {Vec<3>(100.1, 100.1, 0.1), Vec<3>(101.7, 100.3, 0.1),
                                       Vec<3>(100.2, 101.9, 0.1)};
  for (const double z : {std::nextafter(0.1, 0.0), 0.1, std::nextafter(0.1, 1.0)}) {
    const std::array<Vec<3>, 3> above = {Vec<3>(100.7, 100.7, z), Vec<3>(100.6, 100.6, 1),
                                         Vec<3>(100.9, 100.6, 1)};
    EXPECT_EQ(triangles_meet(floor, above), z <= 0.1);
    EXPECT_EQ(triangles_meet(above, floor), z <= 0.1);
  }
  RandomStream random(1, "last bit");
  for (int k = 0; k < 5000; ++k) {
    // A point of the triangle's plane, up to rounding, as a corner of the second triangle.
    const std::array<Vec<3>, 3> t = {random_point(random), random_point(random),
                                     random_point(random)};
    const double u = random.uniform(), v = random.uniform();
    const Vec<3> corner = t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
    const Vec<3> up = (t[1] - t[0]).cross(t[2] - t[0]);
    const std::array<Vec<3>, 3> s = {corner, corner + up, corner + up + 0.1 * t[0]};
    ASSERT_EQ(triangles_meet(s, t), cgal_meet(s, t));
  }
}

TEST(TrianglesMeet, TreatsTrianglesWithoutAreaAsSegments) {
  const std::array<Vec<3>, 3> floor = {Vec<3>(0, 0, 0), Vec<3>(1, 0, 0), Vec<3>(0, 1, 0)};
  const auto needle = [](Vec<3> p, Vec<3> q) { return std::array<Vec<3>, 3>{p, q, 0.5 * (p + q)}; };
  EXPECT_TRUE(triangles_meet(floor, needle({0.25, 0.25, -1}, {0.25, 0.25, 1})));
  EXPECT_FALSE(triangles_meet(floor, needle({0.75, 0.75, -1}, {0.75, 0.75, 1})));
  EXPECT_TRUE(triangles_meet(floor, needle({-1, 0.25, 0}, {2, 0.25, 0})));
  EXPECT_TRUE(triangles_meet(floor, needle({0.25, 0.25, 0}, {0.3, 0.25, 0})));
  EXPECT_FALSE(triangles_meet(floor, needle({-1, 2, 0}, {2, 2, 0})));
  EXPECT_TRUE(triangles_meet(needle({-1, 0, 0}, {1, 0, 0}), needle({0, -1, 0}, {0, 1, 0})));
  EXPECT_FALSE(triangles_meet(needle({-1, 0, 0}, {1, 0, 0}), needle({0, -1, 1}, {0, 1, 1})));
  EXPECT_FALSE(triangles_meet(needle({-1, 0, 0}, {1, 0, 0}), needle({2, 0, 0}, {3, 0, 0})));
}

TEST(IntersectingFaces, AgreesWithEveryPairJudgedByCgal) {
  const TriangleMesh a = make_soup(150, 0.4, "a"), b = make_soup(120, 0.4, "b");
  Pairs expected;
  for (int f = 0; f < a.faces.rows(); ++f) {
    for (int g = 0; g < b.faces.rows(); ++g) {
      if (cgal_meet(corners(a, f), corners(b, g))) expected.push_back({f, g});
    }
  }
  EXPECT_GT(expected.size(), 100u);
  EXPECT_EQ(intersecting_faces({a.vertices, a.faces}, {b.vertices, b.faces}), expected);
}

TEST(IntersectingFaces, CountsTouching) {
  const TriangleMesh cube = make_cube();
  Points3 beside = cube.vertices;
  beside.col(0).array() += 1;
  EXPECT_FALSE(intersecting_faces({cube.vertices, cube.faces}, {beside, cube.faces}).empty());
  beside.col(0).array() += 1e-15;
  EXPECT_TRUE(intersecting_faces({cube.vertices, cube.faces}, {beside, cube.faces}).empty());
}

TEST(SelfIntersectingFaces, AgreesWithEveryPairJudgedByCgal) {
  TriangleMesh mesh = make_sphere(3);
  for (int v = 0; v < mesh.vertices.rows(); ++v) {  // push one side through the other
    if (mesh.vertices(v, 2) > 0.6) mesh.vertices(v, 2) -= 2 * (mesh.vertices(v, 2) - 0.5) + 1.2;
  }
  Pairs expected;
  for (int f = 0; f < mesh.faces.rows(); ++f) {
    for (int g = f + 1; g < mesh.faces.rows(); ++g) {
      bool is_shared = false;
      for (int k = 0; k < 9; ++k) is_shared |= mesh.faces(f, k / 3) == mesh.faces(g, k % 3);
      if (!is_shared && cgal_meet(corners(mesh, f), corners(mesh, g))) expected.push_back({f, g});
    }
  }
  EXPECT_GT(expected.size(), 10u);
  EXPECT_EQ(self_intersecting_faces({mesh.vertices, mesh.faces}), expected);
}

TEST(SelfIntersectingFaces, OfASphereAreNone) {
  const TriangleMesh mesh = make_sphere(4);
  EXPECT_TRUE(self_intersecting_faces({mesh.vertices, mesh.faces}).empty());
}

// What a face of a surface on the move keeps to: along each axis the least and the largest
// coordinate at the start, and the same of its motion.
struct SweptBox {
  Vec<3> low, high, motion_low, motion_high;
};

struct MovingMesh {
  TriangleMesh mesh;
  Eigen::VectorXd reach;
  Points3 motion;  // empty: all stay

  SweptTree tree() const {
    SweptTree tree(SurfaceTree(mesh.vertices, mesh.faces));
    tree.refit(mesh.vertices, reach, motion);
    return tree;
  }
  SweptBox box(int f) const {
    SweptBox box;
    box.motion_low = box.motion_high = Vec<3>::Zero();
    for (int k = 0; k < 3; ++k) {
      const int v = mesh.faces(f, k);
      const Vec<3> x = mesh.vertices.row(v), r = Vec<3>::Constant(reach[v]);
      box.low = k == 0 ? Vec<3>(x - r) : Vec<3>(box.low.cwiseMin(x - r));
      box.high = k == 0 ? Vec<3>(x + r) : Vec<3>(box.high.cwiseMax(x + r));
      if (motion.rows() == 0) continue;
      const Vec<3> u = motion.row(v);
      box.motion_low = k == 0 ? u : Vec<3>(box.motion_low.cwiseMin(u));
      box.motion_high = k == 0 ? u : Vec<3>(box.motion_high.cwiseMax(u));
    }
    return box;
  }
  std::array<Vec<3>, 3> corners_at(int f, double t) const {
    std::array<Vec<3>, 3> x = corners(mesh, f);
    for (int k = 0; k < 3; ++k)
      if (motion.rows() > 0) x[k] += t * motion.row(mesh.faces(f, k)).transpose();
    return x;
  }
};

// Seen along one axis after another: how far two faces stay apart at least, negative where they
// meet.
double gap_on_the_way(const SweptBox& a, const SweptBox& b) {
  double gap = -std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const double least = a.low[k] - b.high[k] + std::min(a.motion_low[k] - b.motion_high[k], 0.0);
    const double most = a.high[k] - b.low[k] + std::max(a.motion_high[k] - b.motion_low[k], 0.0);
    gap = std::max({gap, least, -most});
  }
  return gap;
}

MovingMesh moving_soup(int count, double size, double reach, double speed,
                       const std::string& name) {
  RandomStream random(2, name);
  MovingMesh moving;
  moving.mesh = make_soup(count, size, name);
  moving.reach.resize(3 * count);
  for (double& r : moving.reach) r = reach * random.uniform();
  if (speed == 0) return moving;
  moving.motion.resize(3 * count, 3);
  for (int f = 0; f < count; ++f) {  // each face its own way, turning and stretching a little
    const Vec<3> way = random_point(random, speed);
    for (int k = 0; k < 3; ++k)
      moving.motion.row(3 * f + k) = (way + random_point(random, 0.2 * speed)).transpose();
  }
  return moving;
}

// Bounds are floats, rounded outwards: of coordinates below 4 by less than 5e-7 each.
constexpr double kFloat = 2e-6;

void expect_meeting_faces_of_boxes(const MovingMesh& a, const MovingMesh& b) {
  Pairs found = meeting_faces(a.tree(), b.tree());
  std::sort(found.begin(), found.end());
  EXPECT_TRUE(std::adjacent_find(found.begin(), found.end()) == found.end());
  int meeting = 0;
  for (int f = 0; f < a.mesh.faces.rows(); ++f)
    for (int g = 0; g < b.mesh.faces.rows(); ++g) {
      const double gap = gap_on_the_way(a.box(f), b.box(g));
      const bool is_found =
          std::binary_search(found.begin(), found.end(), std::array<int, 2>{f, g});
      if (gap <= 0) {
        EXPECT_TRUE(is_found) << f << " " << g << " " << gap;
      }
      if (gap > kFloat) {
        EXPECT_FALSE(is_found) << f << " " << g << " " << gap;
      }
      meeting += gap <= 0;
    }
  EXPECT_GT(meeting, 100);
  EXPECT_LT(meeting, a.mesh.faces.rows() * b.mesh.faces.rows() / 3);
}

TEST(SweptTree, FindsJustTheFacesWhoseBoxesMeet) {
  {
    SCOPED_TRACE("still");
    expect_meeting_faces_of_boxes(moving_soup(200, 0.3, 0, 0, "a"),
                                  moving_soup(150, 0.2, 0, 0, "b"));
  }
  {
    SCOPED_TRACE("with reach");
    expect_meeting_faces_of_boxes(moving_soup(200, 0.2, 0.1, 0, "a"),
                                  moving_soup(150, 0.1, 0.2, 0, "b"));
  }
  {
    SCOPED_TRACE("on the move");
    expect_meeting_faces_of_boxes(moving_soup(200, 0.1, 0.05, 0.3, "a"),
                                  moving_soup(150, 0.1, 0, 0.2, "b"));
  }
}

// Of two trees and within one: the pairs with a marked face.
TEST(SweptTree, FindsThePairsOfMarkedFaces) {
  const MovingMesh a = moving_soup(200, 0.2, 0.1, 0, "a"), b = moving_soup(150, 0.1, 0.2, 0, "b");
  std::vector<char> marked(200, 0);
  for (int f = 0; f < 200; f += 7) marked[f] = 1;
  const auto just = [](Pairs pairs, auto is_wanted) {
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(),
                               [&](const std::array<int, 2>& pair) { return !is_wanted(pair); }),
                pairs.end());
    return pairs;
  };
  SweptTree left = a.tree(), right = b.tree();
  const Pairs across = meeting_faces(left, right), within = meeting_faces(left);
  left.mark(marked);
  right.mark(std::vector<char>(150, 0));
  EXPECT_EQ(meeting_faces(left, right),
            just(across, [&](const std::array<int, 2>& pair) { return marked[pair[0]]; }));
  EXPECT_EQ(meeting_faces(left), just(within, [&](const std::array<int, 2>& pair) {
              return marked[pair[0]] || marked[pair[1]];
            }));
  left.mark({});
  EXPECT_EQ(meeting_faces(left, right), across);
  EXPECT_GT(within.size(), 100u);
}

// Boxes that touch without overlap count.
TEST(SweptTree, FindsFacesThatJustTouch) {
  MovingMesh a, b;
  a.mesh = b.mesh = make_cube();
  a.reach = b.reach = Eigen::VectorXd::Zero(8);
  b.mesh.vertices.col(0).array() += 1;
  EXPECT_FALSE(meeting_faces(a.tree(), b.tree()).empty());
  b.mesh.vertices.col(0).array() += 1e-5;
  EXPECT_TRUE(meeting_faces(a.tree(), b.tree()).empty());
  b.reach.setConstant(1.1e-5);
  EXPECT_FALSE(meeting_faces(a.tree(), b.tree()).empty());
  b.reach.setZero();
  a.motion = b.motion = Points3::Zero(8, 3);
  EXPECT_TRUE(meeting_faces(a.tree(), b.tree()).empty());
  a.motion.col(0).setConstant(0.3);
  b.motion.col(0).setConstant(0.3);  // both go the same way
  EXPECT_TRUE(meeting_faces(a.tree(), b.tree()).empty());
  b.motion.col(0).setConstant(0.3 - 1.1e-5);
  EXPECT_FALSE(meeting_faces(a.tree(), b.tree()).empty());
}

TEST(SweptTree, FindsAllThatIntersect) {
  const MovingMesh a = moving_soup(250, 0.4, 0, 0, "a"), b = moving_soup(200, 0.4, 0, 0, "b");
  Pairs found = meeting_faces(a.tree(), b.tree());
  std::sort(found.begin(), found.end());
  const Pairs crossing =
      intersecting_faces({a.mesh.vertices, a.mesh.faces}, {b.mesh.vertices, b.mesh.faces});
  EXPECT_GT(crossing.size(), 100u);
  EXPECT_TRUE(std::includes(found.begin(), found.end(), crossing.begin(), crossing.end()));
}

// Exact tests at 41 instants of the way; at its ends few of the pairs cross.
TEST(SweptTree, FindsAllThatIntersectOnTheWay) {
  const MovingMesh a = moving_soup(100, 0.2, 0, 1, "a"), b = moving_soup(80, 0.2, 0, 1, "b");
  Pairs found = meeting_faces(a.tree(), b.tree());
  std::sort(found.begin(), found.end());
  int crossing = 0, between_only = 0;
  for (int f = 0; f < a.mesh.faces.rows(); ++f)
    for (int g = 0; g < b.mesh.faces.rows(); ++g) {
      bool meets = false, meets_at_end = false;
      for (int i = 0; i <= 40; ++i) {
        const double t = i / 40.0;
        if (!triangles_meet(a.corners_at(f, t), b.corners_at(g, t))) continue;
        meets = true;
        meets_at_end |= i == 0 || i == 40;
      }
      crossing += meets;
      between_only += meets && !meets_at_end;
      if (meets) {
        EXPECT_TRUE(std::binary_search(found.begin(), found.end(), std::array<int, 2>{f, g}));
      }
    }
  EXPECT_GT(crossing, 20);
  EXPECT_GT(between_only, 10);
}

TEST(SweptTree, FindsEachPairOfOneSurfaceOnce) {
  for (const double speed : {0.0, 0.3}) {
    MovingMesh moving;
    moving.mesh = make_sphere(3);
    RandomStream random(4, "crumple");
    for (double& x : moving.mesh.vertices.reshaped()) x *= 0.5 + 0.5 * random.uniform();
    const int count = static_cast<int>(moving.mesh.vertices.rows());
    moving.reach = Eigen::VectorXd::Constant(count, 0.02);
    if (speed > 0) moving.motion.resize(count, 3);
    for (double& u : moving.motion.reshaped()) u = speed * (2 * random.uniform() - 1);
    Pairs found = meeting_faces(moving.tree());
    for (std::array<int, 2>& pair : found) std::sort(pair.begin(), pair.end());
    std::sort(found.begin(), found.end());
    EXPECT_TRUE(std::adjacent_find(found.begin(), found.end()) == found.end());
    const int faces = static_cast<int>(moving.mesh.faces.rows());
    for (int f = 0; f < faces; ++f)
      for (int g = f; g < faces; ++g) {
        const double gap = f == g ? 1 : gap_on_the_way(moving.box(f), moving.box(g));
        const bool is_found =
            std::binary_search(found.begin(), found.end(), std::array<int, 2>{f, g});
        if (gap <= 0) {
          EXPECT_TRUE(is_found) << f << " " << g;
        }
        if (gap > kFloat) {
          EXPECT_FALSE(is_found) << f << " " << g;
        }
      }
    EXPECT_GT(found.size(), 2u * faces);
  }
}

// The tree is that of one pose; its boxes are those of another.
TEST(SweptTree, ForgetsThePoseThatItWasBuiltIn) {
  MovingMesh a = moving_soup(150, 0.2, 0.05, 0, "a"), b = moving_soup(150, 0.2, 0.05, 0, "b");
  SweptTree from_elsewhere(SurfaceTree(b.mesh.vertices, a.mesh.faces));
  from_elsewhere.refit(a.mesh.vertices, a.reach, a.motion);
  SweptTree moved_and_back = a.tree();
  moved_and_back.refit(b.mesh.vertices, b.reach, Points3::Ones(450, 3));
  moved_and_back.refit(a.mesh.vertices, a.reach, a.motion);
  const SweptTree fresh = a.tree(), other = b.tree();
  const Pairs expected = meeting_faces(fresh, other);
  EXPECT_EQ(meeting_faces(a.tree(), b.tree()), expected);  // in the same order, too
  EXPECT_EQ(meeting_faces(moved_and_back, other), expected);
  Pairs found = meeting_faces(from_elsewhere, other), sorted = expected;
  std::sort(found.begin(), found.end());
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(found, sorted);
}

TEST(SweptTree, OfNoFacesMeetsNothing) {
  SweptTree none(SurfaceTree(Points3::Zero(3, 3), Faces(0, 3)));
  none.refit(Points3::Zero(3, 3), Eigen::VectorXd::Constant(3, 10), Points3(0, 3));
  const MovingMesh cube{make_cube(), Eigen::VectorXd::Zero(8), Points3(0, 3)};
  EXPECT_TRUE(meeting_faces(none).empty());
  EXPECT_TRUE(meeting_faces(none, cube.tree()).empty());
  EXPECT_TRUE(meeting_faces(cube.tree(), none).empty());
}

TEST(WindingNumbers, CountTheSurfacesAround) {
  TriangleMesh mesh = make_sphere(3);  // and a second one around its right half
  const int count = static_cast<int>(mesh.vertices.rows()), face_count = mesh.faces.rows();
  mesh.vertices.conservativeResize(2 * count, 3);
  mesh.vertices.bottomRows(count) = mesh.vertices.topRows(count);
  mesh.vertices.bottomRows(count).col(0).array() += 1;
  mesh.faces.conservativeResize(2 * face_count, 3);
  mesh.faces.bottomRows(face_count) = mesh.faces.topRows(face_count).array() + count;
  Points3 queries(5, 3);
  queries << -0.5, 0, 0, 0.5, 0.1, 0, 1.5, 0, 0, 3, 0, 0, 0.5, 0, 0.95;
  const Eigen::VectorXd numbers = winding_numbers({mesh.vertices, mesh.faces}, queries);
  const Vec<5> expected = (Vec<5>() << 1, 2, 1, 0, 0).finished();
  EXPECT_LT((numbers - expected).cwiseAbs().maxCoeff(), 1e-12) << numbers.transpose();
}

TEST(WindingNumbers, OfAnOpenSurfaceAreItsShareOfTheView) {
  const TriangleMesh cube = make_cube();
  const Points3 centre = Points3::Constant(1, 3, 0.5);
  const Faces five_sides = cube.faces.topRows(10);
  EXPECT_NEAR(winding_numbers({cube.vertices, five_sides}, centre)[0], 5.0 / 6, 1e-14);
}

}  // namespace
}  // namespace pleat
