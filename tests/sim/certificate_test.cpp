#include "sim/certificate.h"

#include <gtest/gtest.h>

#include "core/mesh.h"
#include "tests/sim/shapes.h"
#include "tests/validation/judge.h"

namespace pleat::sim {
namespace {

// A sheet over a ball, at rest in its panel's plane.
struct Scene {
  TriangleMesh ball = make_sphere(3, 0.15);
  SurfaceTree posed{ball.vertices, ball.faces};
  BodyCollider collider{ball.vertices, ball.faces};
  Sheet sheet = make_sheet(0.4, 20, 0.16);
  NewtonResult solved;
  AcceptConfig accept;

  Scene() {
    solved.has_converged = solved.is_stable = true;
    solved.residual = 5e-4;
  }
  Points3 positions() const {
    return Eigen::Map<const Points3>(sheet.x.data(), sheet.x.size() / 3, 3);
  }
  garment::Certificate certificate() const {
    return certify(positions(), sheet.faces, sheet.faces, sheet.rest, posed, collider, solved,
                   accept);
  }
  void expect_rejected(const std::string& reason) const {
    const garment::Certificate c = certificate();
    EXPECT_FALSE(c.is_accepted);
    EXPECT_EQ(c.reason, reason);
  }
};

TEST(Certificate, AcceptsWhatIsInOrder) {
  const Scene scene;
  const garment::Certificate c = scene.certificate();
  EXPECT_TRUE(c.is_accepted);
  EXPECT_EQ(c.reason, "");
  EXPECT_EQ(c.residual, 5e-4);
  EXPECT_TRUE(c.is_stable);
  EXPECT_NEAR(c.min_gap_m, 0.01, 1e-3);
  EXPECT_NEAR(c.max_strain, 0, 1e-12);
  EXPECT_EQ(c.body_intersections, 0);
  EXPECT_EQ(c.overlap_intersections, 0);
  EXPECT_EQ(c.self_intersections, 0);
}

TEST(Certificate, NamesWhatIsNot) {
  Scene residual;
  residual.solved.residual = 1.1e-3;
  residual.expect_rejected("not settled");
  Scene stable;
  stable.solved.is_stable = false;
  stable.expect_rejected("not stable");
  Scene strained;
  strained.sheet.rest /= 1.3;
  strained.expect_rejected("too much strain");
  Scene inside;
  inside.sheet = make_sheet(0.05, 4, 0.13);
  inside.expect_rejected("inside the body");
}

// A square millimetre of cloth about a place.
struct Patch {
  Sheet sheet = make_sheet(1e-3, 1, 0);
  Points3 positions = Eigen::Map<const Points3>(sheet.x.data(), sheet.x.size() / 3, 3);

  explicit Patch(const Vec<3>& place) { positions.rowwise() += place.transpose(); }
  double gap_to(const SurfaceTree& posed, const BodyCollider& collider) const {
    return certify(positions, sheet.faces, sheet.faces, sheet.rest, posed, collider, {}, {})
        .min_gap_m;
  }
};

// Every pair of faces by CGAL, for sheets that are let down into the ball, crumpled or folded.
TEST(Certificate, CountsAsCgalDoes) {
  int with_body = 0, with_itself = 0;
  for (const double height : {0.149, 0.12, 0.03})
    for (const double crumple : {0.0, 0.003, 0.02}) {
      Scene scene;
      scene.sheet = make_sheet(0.4, 20, height);
      shake(scene.sheet.x, crumple, "crumple");
      const garment::Certificate c = scene.certificate();
      EXPECT_EQ(c.body_intersections, judge::crossings(scene.positions(), scene.sheet.faces,
                                                       scene.ball.vertices, scene.ball.faces));
      EXPECT_EQ(c.self_intersections, judge::self_crossings(scene.positions(), scene.sheet.faces));
      EXPECT_EQ(c.overlap_intersections, 0);
      with_body += c.body_intersections;
      with_itself += c.self_intersections;
      scene.expect_rejected(c.self_intersections > 0 ? "crosses itself" : "crosses the body");
    }
  EXPECT_GT(with_body, 1000);
  EXPECT_GT(with_itself, 100);
}

// How far the surface of a mesh around the origin, pierced once in each direction, is there.
double radius_towards(const TriangleMesh& mesh, const Vec<3>& direction) {
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    Eigen::Matrix3d corners;
    for (int k = 0; k < 3; ++k) corners.col(k) = mesh.vertices.row(mesh.faces(f, k)).transpose();
    const Vec<3> share = corners.fullPivLu().solve(direction);
    if (share.minCoeff() >= -1e-12) return 1 / share.sum();
  }
  ADD_FAILURE() << "the mesh has a hole";
  return 0;
}

// Among spikes, where the normals of corners lean far from those of the faces around them.
TEST(Certificate, TellsInsideFromOutsideAmongSpikes) {
  Scene scene;
  Eigen::VectorXd radii = Eigen::VectorXd::Ones(scene.ball.vertices.rows());
  shake(radii, 0.35, "spikes");
  scene.ball.vertices.array().colwise() *= radii.array().max(0.5).min(1.7);
  const SurfaceTree posed(scene.ball.vertices, scene.ball.faces);
  const BodyCollider collider(scene.ball.vertices, scene.ball.faces);
  Eigen::VectorXd places = Eigen::VectorXd::Zero(3 * 1500);
  shake(places, 1, "places");
  int inside = 0, outside = 0;
  for (Eigen::Index i = 0; i < places.size(); i += 3) {
    const Vec<3> towards = places.segment<3>(i).normalized();
    const Vec<3> place = (1 + 0.03 * places[i]) * radius_towards(scene.ball, towards) * towards;
    const Patch patch(place);
    bool is_inside = false;
    for (Eigen::Index v = 0; v < patch.positions.rows(); ++v) {
      const Vec<3> x = patch.positions.row(v).transpose();
      is_inside |= x.norm() < radius_towards(scene.ball, x.normalized());
    }
    const double gap = patch.gap_to(posed, collider);
    if (gap == 0.05) continue;  // too far to be measured
    EXPECT_EQ(gap < 0, is_inside) << place.transpose();
    (is_inside ? inside : outside) += 1;
  }
  EXPECT_GT(inside, 100);
  EXPECT_GT(outside, 100);
}

// A corner of the ball pushed through its other side.
struct PiercedBall : Scene {
  Eigen::Index pole;
  Points3 pierced = ball.vertices;

  PiercedBall() {
    ball.vertices.col(1).maxCoeff(&pole);
    pierced.row(pole) *= -1.2;
    collider.move_to(pierced);
  }
};

// On the rim of the faces that are switched off there normals say little, and nothing holds cloth
// off: nothing is measured. Elsewhere all is.
TEST(Certificate, MeasuresNothingOnTheRimOfWhatIsSwitchedOff) {
  const PiercedBall scene;
  const std::vector<std::vector<int>> neighbours =
      vertex_neighbours(scene.ball.faces, scene.pierced.rows());
  const auto gap_at = [&](const Vec<3>& place) {
    return Patch(place).gap_to(scene.posed, scene.collider);
  };
  constexpr double kNone = 0.05;
  for (const int v : neighbours[scene.pole])
    EXPECT_EQ(gap_at(1.05 * scene.pierced.row(v).transpose()), kNone) << v;
  for (const double share : {0.95, 1.05}) {
    const double gap = gap_at(share * Vec<3>(scene.pierced.col(0).maxCoeff(), 0, 0));
    EXPECT_NEAR(gap, (share - 1) * 0.15, 1e-3);
  }
}

TEST(Certificate, CountsApartWhatCrossesNextToWhatIsSwitchedOff) {
  const PiercedBall scene;
  const SurfaceTree posed(scene.pierced, scene.ball.faces);
  int beside = 0;
  for (Eigen::Index f = 0; f < scene.ball.faces.rows(); ++f) {
    const int face = static_cast<int>(f);
    const Vec<3> middle = scene.collider.point(face, Vec<3>::Constant(1. / 3));
    if (std::abs(middle.normalized().y()) > 0.999) continue;  // where the patch does not cross
    const Patch patch(middle);
    const garment::Certificate c = certify(patch.positions, patch.sheet.faces, patch.sheet.faces,
                                           patch.sheet.rest, posed, scene.collider, {}, {});
    const bool is_clear = scene.collider.is_clear(face);
    EXPECT_EQ(c.body_intersections > 0, is_clear) << f;
    EXPECT_EQ(c.overlap_intersections > 0, !is_clear) << f;
    beside += !is_clear && !scene.collider.is_off()[face];
  }
  EXPECT_GT(beside, 10);
}

// Skin that gave way: the cloth lies in the body as posed, and outside of the body as it gave way.
TEST(Certificate, CountsApartWhatGaveWay) {
  Scene scene;
  scene.sheet = make_sheet(0.4, 20, 0.145);
  Points3 pressed = scene.ball.vertices;
  for (Eigen::Index v = 0; v < pressed.rows(); ++v)
    if (pressed(v, 1) > 0.1) pressed(v, 1) = 0.1 + 0.8 * (pressed(v, 1) - 0.1);
  scene.collider.move_to(pressed);
  const garment::Certificate c = scene.certificate();
  EXPECT_TRUE(c.is_accepted) << c.reason;
  EXPECT_EQ(c.body_intersections, 0);
  EXPECT_EQ(c.overlap_intersections, judge::crossings(scene.positions(), scene.sheet.faces,
                                                      scene.ball.vertices, scene.ball.faces));
  EXPECT_GT(c.overlap_intersections, 10);
}

TEST(Certificate, ChecksItsSettings) {
  AcceptConfig config;
  EXPECT_NO_THROW(validate(config));
  config.residual = 0;
  EXPECT_ANY_THROW(validate(config));
  config = {};
  config.strain_95 = -1;
  EXPECT_ANY_THROW(validate(config));
}

}  // namespace
}  // namespace pleat::sim
