#include "sim/body_contact.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tests/sim/shapes.h"

namespace pleat::sim {
namespace {

// As contact asks for it: around the nearest face, with the normal of the nearest point.
BodyField field_at(const BodyCollider& body, const Vec<3>& x, int order = 2) {
  const ClosestPoint closest = body.tree().closest(x, 1);
  return body.field(closest.face, body.normal(closest.face, closest.barycentric), x, 1, order);
}

struct Errors {
  double distance = 0, angle = 0, slope = 0, curvature = 0;  // the largest; m, rad, 1, share
};

Errors errors_on_sphere(int levels, double radius, double height) {
  const TriangleMesh sphere = make_sphere(levels, radius);
  const BodyCollider body(sphere.vertices, sphere.faces);
  RandomStream random(1, "directions");
  Errors errors;
  for (int i = 0; i < 1000; ++i) {
    const Vec<3> up = random_point(random).normalized();
    const BodyField field = field_at(body, (radius + height) * up);
    errors.distance = std::max(errors.distance, std::abs(field.phi - height));
    const double cosine = std::min(1.0, field.gradient.normalized().dot(up));
    errors.angle = std::max(errors.angle, std::acos(cosine));
    errors.slope = std::max(errors.slope, std::abs(field.gradient.norm() - 1));
    errors.curvature =
        std::max(errors.curvature, std::abs(field.hessian.trace() * (radius + height) / 2 - 1));
  }
  return errors;
}

// A ball of 15 cm with edges of 1.2 to 1.9 cm, as a body has them. Its mesh lies up to 0.3 mm
// inside; the smooth surface follows the ball itself within half of that.
TEST(BodyCollider, FieldIsTheDistanceToASphere) {
  for (const double height : {-0.002, 0.0, 0.003, 0.006}) {
    const Errors errors = errors_on_sphere(4, 0.15, height);
    EXPECT_LT(errors.distance, 1.5e-4) << height;
    EXPECT_LT(errors.angle, 0.01) << height;
    EXPECT_LT(errors.slope, 0.01) << height;
    EXPECT_LT(errors.curvature, 0.5) << height;
  }
}

TEST(BodyCollider, FieldConvergesWithTheMesh) {
  const Errors coarse = errors_on_sphere(3, 0.15, 0.003), fine = errors_on_sphere(5, 0.15, 0.003);
  EXPECT_LT(fine.distance, coarse.distance / 4);
  EXPECT_LT(fine.angle, coarse.angle / 2);
  EXPECT_LT(fine.slope, coarse.slope / 4);
}

TEST(BodyCollider, FieldOfAPlaneIsExact) {
  const Sheet sheet = make_sheet(0.4, 20, 0);
  const Mat<3> turn = Eigen::AngleAxisd(0.8, Vec<3>(1, 2, -1).normalized()).toRotationMatrix();
  Points3 vertices = Eigen::Map<const Points3>(sheet.x.data(), sheet.rest.rows(), 3);
  vertices = (vertices * turn.transpose()).rowwise() + Vec<3>(0.1, 0.2, 0.3).transpose();
  const BodyCollider body(vertices, sheet.faces);
  RandomStream random(2, "plane");
  for (int i = 0; i < 200; ++i) {
    const Vec<3> local(0.2 * random.uniform() - 0.1, 0.02 * random.uniform() - 0.01,
                       0.2 * random.uniform() - 0.1);
    const BodyField field = field_at(body, turn * local + Vec<3>(0.1, 0.2, 0.3));
    // Of rounding: 1e-16 m, amplified by the weights' slopes of 100 / m.
    EXPECT_NEAR(field.phi, local.y(), 1e-15);
    EXPECT_LE((field.gradient - turn.col(1)).norm(), 1e-13);
    EXPECT_LE(field.hessian.norm(), 1e-10);
  }
}

TEST(BodyCollider, FieldIsNegativeInside) {
  const TriangleMesh bumpy = make_bumpy_ball(4, 0.15, 0.06);
  const BodyCollider body(bumpy.vertices, bumpy.faces);
  RandomStream random(3, "sides");
  for (int i = 0; i < 1000; ++i) {
    const Vec<3> up = random_point(random).normalized();
    const double radius = bumpy_radius(up, 0.15, 0.06);
    for (const double height : {0.002, 0.008}) {
      EXPECT_GT(field_at(body, (radius + height) * up).phi, 0);
      EXPECT_LT(field_at(body, (radius - height) * up).phi, 0);
    }
  }
}

// Central differences of 1e-6 m with face and normal held, as the solver holds them within an
// iteration.
TEST(BodyCollider, GradientAndHessianAreDerivativesOfTheField) {
  const TriangleMesh bumpy = make_bumpy_ball(4, 0.15, 0.06);
  const BodyCollider body(bumpy.vertices, bumpy.faces);
  RandomStream random(4, "derivatives");
  for (int i = 0; i < 100; ++i) {
    const Vec<3> up = random_point(random).normalized();
    const Vec<3> x = (bumpy_radius(up, 0.15, 0.06) + 0.008 * random.uniform() - 0.002) * up;
    const ClosestPoint closest = body.tree().closest(x, 1);
    const Vec<3> normal = body.normal(closest.face, closest.barycentric);
    const BodyField at = body.field(closest.face, normal, x, 1, 2);
    EXPECT_EQ(body.field(closest.face, normal, x, 1, 0).phi, at.phi);
    EXPECT_EQ(body.field(closest.face, normal, x, 1, 1).gradient, at.gradient);
    const double h = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const BodyField above = body.field(closest.face, normal, x + h * Vec<3>::Unit(k), 1, 1);
      const BodyField below = body.field(closest.face, normal, x - h * Vec<3>::Unit(k), 1, 1);
      EXPECT_NEAR((above.phi - below.phi) / (2 * h), at.gradient[k], 1e-7);
      EXPECT_LE(((above.gradient - below.gradient) / (2 * h) - at.hessian.col(k)).norm(),
                1e-5 * (1 + at.hessian.norm()));
    }
  }
}

// Without a jump, over which a vertex would step to and fro.
TEST(BodyCollider, FieldFadesWhereItEnds) {
  const TriangleMesh bumpy = make_bumpy_ball(4, 0.15, 0.06);
  const BodyCollider body(bumpy.vertices, bumpy.faces);
  constexpr double kBeyond = 0.004, kStep = 2e-5, h = 1e-7;
  int fading = 0, ends = 0;
  for (int face = 0; face < body.faces().rows(); face += 97) {
    const Vec<3> bary(0.3, 0.3, 0.4), normal = body.normal(face, bary);
    const auto at = [&](double height, int order) {
      return body.field(face, normal, body.point(face, bary) + height * normal, kBeyond, order);
    };
    double last = at(0.002, 0).phi;
    for (double height = 0.002; height < 0.06; height += kStep) {
      const BodyField field = at(height, 2);
      EXPECT_LE(std::abs(field.phi - last), 0.002) << face << " at " << height;
      last = field.phi;
      const BodyField above = at(height + h, 1), below = at(height - h, 1);
      EXPECT_NEAR((above.phi - below.phi) / (2 * h), field.gradient.dot(normal),
                  1e-5 * (1 + field.gradient.norm()));
      EXPECT_LE(((above.gradient - below.gradient) / (2 * h) - field.hessian * normal).norm(),
                1e-4 * (100 + field.hessian.norm()));
      fading += field.phi != kBeyond && std::abs(field.gradient.dot(normal)) > 2;
    }
    ends += last == kBeyond;
  }
  EXPECT_GT(fading, 10);
  EXPECT_GT(ends, 10);
}

struct Walk {
  int faces = 0;  // entered on the way
  // The largest change from step to step: of phi beyond its slope, of the gradient.
  double jump = 0, turn = 0;
};

// A way around the body, 3 mm over the smooth shape that the mesh was made of.
Walk walk(const BodyCollider& body, int steps, double height) {
  const Mat<3> tilt = Eigen::AngleAxisd(0.6, Vec<3>(1, 0.5, 0.2).normalized()).toRotationMatrix();
  Walk walk;
  BodyField last;
  Vec<3> last_x = Vec<3>::Zero();
  last.gradient.setZero();
  int last_face = -1;
  for (int i = 0; i <= steps; ++i) {
    const double angle = 0.8 * i / steps;  // about 12 cm
    const Vec<3> up = tilt * Vec<3>(std::cos(angle), std::sin(angle), 0.1).normalized();
    const Vec<3> x = (bumpy_radius(up, 0.15, 0.06) + height) * up;
    const int face = body.tree().closest(x, 1).face;
    const BodyField field = field_at(body, x, 1);
    if (i > 0) {
      const double slope = 0.5 * (field.gradient + last.gradient).dot(x - last_x);
      walk.faces += face != last_face;
      walk.jump = std::max(walk.jump, std::abs(field.phi - last.phi - slope));
      walk.turn = std::max(walk.turn, (field.gradient - last.gradient).norm());
    }
    last = field;
    last_x = x;
    last_face = face;
  }
  return walk;
}

// Over edges and corners of the mesh the nearest face changes at every step of some: a field that
// jumped there would jump as far however small the steps. Phi's jumps beyond its slope fall with
// their square at least, the gradient's with the step.
TEST(BodyCollider, FieldIsContinuousAcrossTheMesh) {
  const TriangleMesh bumpy = make_bumpy_ball(4, 0.15, 0.06);
  const BodyCollider body(bumpy.vertices, bumpy.faces);
  for (const double height : {0.003, 0.0}) {
    const Walk coarse = walk(body, 4000, height), fine = walk(body, 40000, height);
    EXPECT_GT(fine.faces, 20);
    EXPECT_LT(coarse.turn, 0.01);
    EXPECT_LT(fine.turn, 1.2 * coarse.turn / 10);
    EXPECT_LT(fine.jump, 1.2 * coarse.jump / 10);
  }
}

// What the field knows of a body it knows in every pose.
TEST(BodyCollider, FieldGoesWithTheBody) {
  const TriangleMesh bumpy = make_bumpy_ball(3, 0.15, 0.06);
  const Mat<3> turn = Eigen::AngleAxisd(2, Vec<3>(1, 2, 3).normalized()).toRotationMatrix();
  const Vec<3> shift(0.5, 1, -0.2);
  const BodyCollider still(bumpy.vertices, bumpy.faces);
  BodyCollider moved(bumpy.vertices, bumpy.faces);
  moved.move_to(Points3((bumpy.vertices * turn.transpose()).rowwise() + shift.transpose()));
  RandomStream random(6, "poses");
  for (int i = 0; i < 100; ++i) {
    const Vec<3> up = random_point(random).normalized();
    const Vec<3> x = (bumpy_radius(up, 0.15, 0.06) + 0.003) * up;
    const BodyField here = field_at(still, x), there = field_at(moved, turn * x + shift);
    EXPECT_NEAR(here.phi, there.phi, 1e-14);
    EXPECT_LE((turn * here.gradient - there.gradient).norm(), 1e-12);
    EXPECT_LE((turn * here.hessian * turn.transpose() - there.hessian).norm(), 1e-9);
  }
}

// Between the faces of a gap of 6 mm each side knows its own surface only.
TEST(BodyCollider, FieldLooksPastWhatFacesTheOtherWay) {
  TriangleMesh lower = make_sphere(4, 0.15), upper = lower;
  upper.vertices.col(1).array() += 0.306;
  const TriangleMesh both = join(lower, upper);
  const BodyCollider body(both.vertices, both.faces);
  const BodyCollider alone(lower.vertices, lower.faces);
  const Vec<3> x(0.001, 0.1525, 0.002);
  const BodyField of_both = field_at(body, x), of_one = field_at(alone, x);
  EXPECT_EQ(of_both.phi, of_one.phi);
  EXPECT_EQ(of_both.gradient, of_one.gradient);
}

TEST(BodyCollider, FieldOutOfReachIsFar) {
  const TriangleMesh sphere = make_sphere(4, 0.15);
  const BodyCollider body(sphere.vertices, sphere.faces);
  const BodyField field = body.field(0, body.normal(0, {1, 0, 0}), {0, 0.5, 0}, 1, 2);
  EXPECT_GE(field.phi, 0.5);
  EXPECT_EQ(field.gradient, Vec<3>::Zero());
  EXPECT_EQ(field.hessian, Mat<3>::Zero());
}

}  // namespace
}  // namespace pleat::sim
