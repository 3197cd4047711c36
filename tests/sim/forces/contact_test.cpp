#include "sim/forces/contact.h"

#include <cmath>
#include <vector>

#include "check_derivatives.h"
#include "tests/sim/shapes.h"

namespace pleat::sim {
namespace {

constexpr double kDistance = 0.0035, kStiffness = 900;  // m, N/m

// A contact and the place of its vertex, at phi from the body's smooth surface.
struct Case {
  Contact contact;
  Vec<3> x;
};

std::vector<Case> cases_at(const BodyCollider& body, double phi) {
  std::vector<Case> cases;
  RandomStream random(3, "cases");
  for (int i = 0; i < 12; ++i) {
    const int face = static_cast<int>(random.below(body.faces().rows()));
    const double u = random.uniform(), v = (1 - u) * random.uniform();
    const Vec<3> barycentric(u, v, 1 - u - v), normal = body.normal(face, barycentric);
    Vec<3> x = body.point(face, barycentric) + phi * normal;
    for (int k = 0; k < 20; ++k) {
      const BodyField field = body.field(face, normal, x, 1, 1);
      x += (phi - field.phi) / field.gradient.squaredNorm() * field.gradient;
    }
    EXPECT_NEAR(body.field(face, normal, x, 1, 0).phi, phi, 1e-15);
    cases.push_back({{0, face, barycentric, normal, kDistance, kStiffness, x, 0, false}, x});
  }
  return cases;
}

struct Bodies {
  TriangleMesh sphere = make_sphere(4, 0.15), bumpy = make_bumpy_ball(4, 0.15, 0.06);
  BodyCollider on_sphere{sphere.vertices, sphere.faces}, on_bumps{bumpy.vertices, bumpy.faces};
};
const Bodies& bodies() {
  static const Bodies bodies;
  return bodies;
}
const std::vector<const BodyCollider*>& colliders() {
  static const std::vector<const BodyCollider*> list = {&bodies().on_sphere, &bodies().on_bumps};
  return list;
}

// Steps of 1e-7 m: the field's third derivatives are below 1e5 / m^2, its edges' length squared, so
// that 1e-9 is left of the step, and of rounding 1e-8.
TEST(Contact, DerivativesMatchDifferencesInEveryRegime) {
  for (const BodyCollider* body : colliders())
    for (const double phi :
         {1.3 * kDistance, 0.9 * kDistance, 0.3 * kDistance, -0.2 * kDistance, -1.2 * kDistance}) {
      SCOPED_TRACE(phi);
      for (const Case& c : cases_at(*body, phi)) {
        const auto energy = [&](const Vec<3>& x, Order order) {
          return contact_energy(c.contact, *body, x, order);
        };
        expect_derivatives_match<3>(energy, c.x, 1e-7, 1e-5);
      }
    }
}

TEST(Contact, ActsOnlyWithinItsDistance) {
  for (const BodyCollider* body : colliders())
    for (const Case& c : cases_at(*body, 1.001 * kDistance)) {
      const LocalEnergy<3> energy = contact_energy(c.contact, *body, c.x, Order::kHessian);
      EXPECT_EQ(energy.value, 0);
      EXPECT_EQ(energy.gradient, Vec<3>::Zero());
      EXPECT_EQ(energy.hessian, Mat<3>::Zero());
      EXPECT_EQ(normal_force(c.contact, 1.001 * kDistance), 0);
    }
}

// Where a vertex has room it is taken to be free without a look at the body, but no farther.
TEST(Contact, CostsNothingWithinItsRoom) {
  for (const Case& c : cases_at(bodies().on_bumps, 0.5 * kDistance)) {
    Contact roomy = c.contact;
    roomy.seen_at = c.x + Vec<3>(0, 0.01, 0);
    roomy.room = 0.0101;
    const LocalEnergy<3> within =
        contact_energy(roomy, bodies().on_bumps, c.x, Order::kProjectedHessian);
    EXPECT_EQ(within.value, 0);
    EXPECT_EQ(within.gradient, Vec<3>::Zero());
    EXPECT_EQ(within.hessian, Mat<3>::Zero());
    roomy.room = 0.0099;
    const LocalEnergy<3> beyond = contact_energy(roomy, bodies().on_bumps, c.x, Order::kGradient);
    EXPECT_EQ(beyond.gradient,
              contact_energy(c.contact, bodies().on_bumps, c.x, Order::kGradient).gradient);
    EXPECT_GT(beyond.value, 0);
  }
}

// The force is -dE/dphi along the field's gradient, a unit vector up to the blend's error.
TEST(Contact, PushesOutwardByTheNormalForce) {
  for (const BodyCollider* body : colliders())
    for (const double phi : {0.9 * kDistance, 0.0, -1.2 * kDistance})
      for (const Case& c : cases_at(*body, phi)) {
        const Vec<3> force = -contact_energy(c.contact, *body, c.x, Order::kGradient).gradient;
        const Vec<3> up = body->field(c.contact.body_face, c.contact.normal, c.x, 1, 1).gradient;
        const double expected = normal_force(c.contact, phi);
        EXPECT_GT(expected, 0);
        EXPECT_LE((force - expected * up).norm(), 1e-11);
        EXPECT_NEAR(force.norm(), expected, 0.05 * expected);
        EXPECT_GT(force.dot(c.contact.normal), 0.95 * expected);
      }
}

// E'' = k min(u/d, 1): hence E' = k d/2 on the surface and k (d/2 + depth) below it.
TEST(Contact, SpringIsThatOfItsFormula) {
  const Contact contact{
      0, 0, Vec<3>(1, 0, 0), Vec<3>(0, 1, 0), kDistance, kStiffness, Vec<3>(0, 0, 0), 0, false};
  const double k = kStiffness, d = kDistance;
  EXPECT_EQ(normal_force(contact, d), 0);
  EXPECT_NEAR(normal_force(contact, 0.5 * d), k * d / 8, 1e-14);
  EXPECT_NEAR(normal_force(contact, 0), k * d / 2, 1e-14);
  EXPECT_NEAR(normal_force(contact, -d), 1.5 * k * d, 1e-14);
  for (const double joint : {d, 0.0}) {  // continuous, and so is its slope
    const double h = 1e-7;
    const double above = normal_force(contact, joint + h), at = normal_force(contact, joint),
                 below = normal_force(contact, joint - h);
    EXPECT_NEAR(above - at, at - below, 2 * k * h * h / d);
  }
}

TEST(Contact, ProjectedHessianIsPositive) {
  for (const BodyCollider* body : colliders())
    for (const double phi : {0.9 * kDistance, 0.1 * kDistance, -1.2 * kDistance})
      for (const Case& c : cases_at(*body, phi)) {
        const auto energy = [&](const Vec<3>& x, Order order) {
          return contact_energy(c.contact, *body, x, order);
        };
        EXPECT_GE(smallest_eigenvalue<3>(energy, c.x), -1e-15);
      }
}

// Over a ball of radius R the field's Hessian is that of the distance, (I - n n^T) / R: a vertex
// that is pushed off it gains by sliding aside, with the stiffness -E'/R.
TEST(Contact, ExactHessianHasTheBodysCurvature) {
  const BodyCollider& body = bodies().on_sphere;
  double sum = 0;
  const std::vector<Case> cases = cases_at(body, 0.001);
  for (const Case& c : cases) {
    const Mat<3> exact = contact_energy(c.contact, body, c.x, Order::kHessian).hessian;
    const Vec<3> n = c.x.normalized();
    const double aside = exact.trace() - n.dot(exact * n);
    sum += aside / 2 / -normal_force(c.contact, 0.001) * c.x.norm();
  }
  EXPECT_NEAR(sum / cases.size(), 1, 0.1);  // on average; the blend ripples from vertex to vertex
}

}  // namespace
}  // namespace pleat::sim
