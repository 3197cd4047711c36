#include "sim/forces/barrier.h"

#include <Eigen/Geometry>
#include <cmath>
#include <string>
#include <vector>

#include "check_derivatives.h"
#include "core/random.h"

namespace pleat::sim {
namespace {

constexpr double kDistance = 0.002, kStiffness = 0.05;  // m, N

// Four points with a name for the place where the distance is measured there.
struct Case {
  std::string name;
  PairKind kind;
  PairPoints points;
  int free;
};

PairPoints millimetres(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d) {
  PairPoints x;
  x << a, b, c, d;
  return 1e-3 * x;
}

// About 1 mm apart, no place nearer than a tenth of the features' size to the next kind.
std::vector<Case> all_cases() {
  std::vector<Case> cases;
  const Vec<3> a(0, 0, 0), b(12, 1, 0.5), c(3, 10, -0.3);
  const auto face = [&](const std::string& name, const Vec<3>& p, int free) {
    cases.push_back({name, PairKind::kPointFace, millimetres(p, a, b, c), free});
  };
  face("inside", {4, 4, 1}, 2);
  face("over edge 0", {6, -0.4, 0.9}, 1);
  face("over edge 1", {8.2, 6.4, 0.8}, 1);
  face("over edge 2", {0.8, 5.2, -0.7}, 1);
  face("at corner 0", {-0.6, -0.5, 0.7}, 0);
  face("at corner 1", {12.9, 0.9, 0.9}, 0);
  face("at corner 2", {3.1, 10.8, 0.3}, 0);
  const Vec<3> p(-6, 0.3, 0.2), q(6, -0.4, 0);
  const auto edges = [&](const std::string& name, const Vec<3>& from, const Vec<3>& to, int free) {
    cases.push_back({name, PairKind::kEdgeEdge, millimetres(p, q, from, to), free});
    cases.push_back({name + ", swapped", PairKind::kEdgeEdge, millimetres(from, to, p, q), free});
  };
  edges("crossing", {1, -5, 1.2}, {2, 6, 0.9}, 2);
  edges("crossing at a flat angle", {-4, -1, 1}, {5, 1.5, 1.1}, 2);
  edges("start of one", {2, 0.8, 0.9}, {3, 8, 2}, 1);
  edges("end of one", {3, 8, -2}, {2, 0.8, -0.9}, 1);
  edges("start and start", {-6.7, 0.6, 0.8}, {-9, 7, 3}, 0);
  edges("end and start", {6.7, 0.6, 0.8}, {9, 7, 3}, 0);
  return cases;
}

constexpr double kParallel = 1e-12;  // m^4: below every case's |a x b|^2
Barrier barrier_of(const Case& c) {
  return {{0, 1, 2, 3}, c.kind, kDistance, kStiffness, kParallel};
}
Vec<12> stacked(const PairPoints& points) { return Eigen::Map<const Vec<12>>(points.data()); }
auto energy_of(const Case& c) {
  return [barrier = barrier_of(c)](const Vec<12>& x, Order order) {
    return barrier_energy(barrier, x, order);
  };
}
double distance_of(const Case& c) { return std::sqrt(squared_pair_distance(c.kind, c.points)); }

// The same with its distance scaled, the place on the features kept.
Case at_distance(Case c, double distance) {
  const PairDistance there = pair_distance(c.kind, c.points);
  const Vec<3> away = there.difference.normalized() * (distance - std::sqrt(there.squared));
  const int first = c.kind == PairKind::kPointFace ? 1 : 2;
  for (int k = 0; k < first; ++k) c.points.col(k) += away;
  return c;
}

TEST(Barrier, CasesAreWhatTheirNamesSay) {
  for (const Case& c : all_cases()) {
    SCOPED_TRACE(c.name);
    EXPECT_EQ(pair_distance(c.kind, c.points).free, c.free);
    EXPECT_GT(distance_of(c), 0.2 * kDistance);
    EXPECT_LT(distance_of(c), 0.9 * kDistance);
    EXPECT_NEAR(distance_of(at_distance(c, 1e-4)), 1e-4, 1e-12);
  }
}

// Steps of 1e-5 of the distance: 1e-10 of the derivatives is left of them, 1e-9 of rounding.
TEST(Barrier, DerivativesMatchDifferencesAtEveryPlace) {
  for (const Case& c : all_cases())
    for (const double distance : {1.9e-3, 1e-3, 2e-4}) {
      SCOPED_TRACE(c.name + " at " + std::to_string(distance));
      const Case at = at_distance(c, distance);
      expect_derivatives_match<12>(energy_of(at), stacked(at.points), 1e-5 * distance, 1e-6);
    }
}

TEST(Barrier, GrowsWithoutBoundTowardsZero) {
  for (const Case& c : all_cases()) {
    SCOPED_TRACE(c.name);
    double last = 0;
    for (double distance = 1e-3; distance > 1e-9; distance /= 10) {
      const Case at = at_distance(c, distance);
      const BarrierTerm term = barrier_term(barrier_of(at), at.points, Order::kHessian);
      // B(u) > -(1 - 2 u) ln u, and its slope is below -(1 - 2 u) / u.
      const double u = distance_of(at) / kDistance;
      EXPECT_GT(term.value, kStiffness * kDistance * (1 - 2 * u) * -std::log(u));
      EXPECT_LT(term.slope, -kStiffness * (1 - 2 * u) / u);
      EXPECT_GT(term.value, last);
      last = term.value;
    }
  }
}

// B = (1 - u)^3 near u = 1, so that with e = 1 - u energy, force and stiffness are e^3, 3 e^2 and 6
// e of theirs, up to the next order in e.
TEST(Barrier, StartsTwiceDifferentiable) {
  for (const Case& c : all_cases()) {
    SCOPED_TRACE(c.name);
    for (const double e : {1e-2, 1e-3, 1e-4}) {
      const Case at = at_distance(c, (1 - e) * kDistance);
      const BarrierTerm term = barrier_term(barrier_of(at), at.points, Order::kHessian);
      EXPECT_NEAR(term.value / (kStiffness * kDistance), e * e * e, 2 * e * e * e * e);
      EXPECT_NEAR(term.slope / kStiffness, -3 * e * e, 6 * e * e * e);
      EXPECT_NEAR(term.radial * kDistance / kStiffness, 6 * e, 12 * e * e);
      const LocalEnergy<12> energy = energy_of(at)(stacked(at.points), Order::kHessian);
      EXPECT_LE(energy.hessian.norm() * kDistance / kStiffness, 40 * e);  // |w|^2 <= 4
    }
    for (const double beyond : {1.0 + 1e-9, 1.5}) {
      const Case at = at_distance(c, beyond * kDistance);
      const LocalEnergy<12> energy = energy_of(at)(stacked(at.points), Order::kHessian);
      EXPECT_EQ(energy.value, 0);
      EXPECT_EQ(energy.gradient, Vec<12>::Zero());
      EXPECT_EQ(energy.hessian, Mat<12>::Zero());
    }
  }
}

TEST(Barrier, PushesApartAndBalances) {
  for (const Case& c : all_cases()) {
    SCOPED_TRACE(c.name);
    const BarrierTerm term = barrier_term(barrier_of(c), c.points, Order::kGradient);
    const Vec<3> away = pair_distance(c.kind, c.points).difference.normalized();
    Vec<3> first = Vec<3>::Zero(), all = Vec<3>::Zero(), moment = Vec<3>::Zero();
    for (int k = 0; k < 4; ++k) {
      const Vec<3> force = -force_gradient(term, k);
      if (k < (c.kind == PairKind::kPointFace ? 1 : 2)) first += force;
      all += force;
      moment += Vec<3>(c.points.col(k)).cross(force);
    }
    EXPECT_NEAR(first.dot(away), -term.slope, 1e-14);
    EXPECT_LE(first.cross(away).norm(), 1e-14);
    EXPECT_LE(all.norm(), 1e-15);
    EXPECT_LE(moment.norm(), 1e-17);
  }
}

TEST(Barrier, ProjectedHessianIsPositive) {
  for (const Case& c : all_cases())
    for (const double distance : {1.9e-3, 1e-3, 2e-5}) {
      const Case at = at_distance(c, distance);
      EXPECT_GE(smallest_eigenvalue<12>(energy_of(at), stacked(at.points)), -1e-14) << c.name;
    }
}

// The exact Hessian is not: along the features a pair that is pushed apart gives way.
TEST(Barrier, ExactHessianHasWhatTheProjectionLeavesOut) {
  const Case inside = at_distance(all_cases().front(), 1e-3);
  const Mat<12> exact = energy_of(inside)(stacked(inside.points), Order::kHessian).hessian;
  EXPECT_LT(Eigen::SelfAdjointEigenSolver<Mat<12>>(exact).eigenvalues()[0], -1e-3 * exact.norm());
}

TEST(Barrier, ProductsAreThoseOfTheBlocks) {
  RandomStream random(1, "products");
  for (const Case& c : all_cases())
    for (const Order order : {Order::kProjectedHessian, Order::kHessian}) {
      SCOPED_TRACE(c.name);
      const BarrierTerm term = barrier_term(barrier_of(c), c.points, order);
      const Mat<12> hessian = energy_of(c)(stacked(c.points), order).hessian;
      EXPECT_LE((hessian - hessian.transpose()).norm(), 1e-14 * hessian.norm());
      PairPoints p, expected;
      for (double& number : p.reshaped()) number = random.normal();
      expected.setZero();
      for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) {
          expected.col(a) += hessian_block(term, a, b) * p.col(b);
          EXPECT_EQ((hessian.block<3, 3>(3 * a, 3 * b)), hessian_block(term, a, b));
        }
      EXPECT_LE((hessian_product(term, p) - expected).norm(), 1e-13 * hessian.norm() * p.norm());
    }
}

TEST(Barrier, RigidMotionChangesNothing) {
  const Mat<3> turn = Eigen::AngleAxisd(1.1, Vec<3>(1, 2, 3).normalized()).toRotationMatrix();
  for (const Case& c : all_cases()) {
    SCOPED_TRACE(c.name);
    Case moved = c;
    moved.points = (turn * c.points).colwise() + Vec<3>(0.3, -0.2, 0.1);
    const LocalEnergy<12> here = energy_of(c)(stacked(c.points), Order::kHessian);
    const LocalEnergy<12> there = energy_of(c)(stacked(moved.points), Order::kHessian);
    // Coordinates of 0.3 m are rounded to 1e-16 m, 1e-13 of the distance; curvature takes a tenth
    // more.
    EXPECT_NEAR(there.value, here.value, 1e-11 * here.value);
    for (int a = 0; a < 4; ++a) {
      const Vec<3> gradient = turn * here.gradient.segment<3>(3 * a);
      EXPECT_LE((there.gradient.segment<3>(3 * a) - gradient).norm(), 1e-11 * here.gradient.norm());
      for (int b = 0; b < 4; ++b) {
        const Mat<3> block = turn * here.hessian.block<3, 3>(3 * a, 3 * b) * turn.transpose();
        EXPECT_LE((there.hessian.block<3, 3>(3 * a, 3 * b) - block).norm(),
                  1e-10 * here.hessian.norm());
      }
    }
  }
}

// Between edges that are nearly parallel: m(t) = t (2 - t) times the energy, t = c / c_0.
TEST(Barrier, FadesOutBetweenParallelEdges) {
  for (const Case& c : all_cases()) {
    if (c.kind != PairKind::kEdgeEdge) continue;
    SCOPED_TRACE(c.name);
    const Vec<3> a = c.points.col(1) - c.points.col(0), b = c.points.col(3) - c.points.col(2);
    const double full = barrier_energy(barrier_of(c), stacked(c.points), Order::kValue).value;
    for (const double t : {0.02, 0.3, 0.9}) {
      Barrier barrier = barrier_of(c);
      barrier.parallel = a.cross(b).squaredNorm() / t;
      const auto energy = [&](const Vec<12>& x, Order order) {
        return barrier_energy(barrier, x, order);
      };
      const LocalEnergy<12> here = energy(stacked(c.points), Order::kHessian);
      EXPECT_NEAR(here.value, t * (2 - t) * full, 1e-9 * full);
      expect_derivatives_match<12>(energy, stacked(c.points), 1e-8, 1e-5);
    }
    Barrier never = barrier_of(c);
    never.parallel = 1;
    EXPECT_EQ(barrier_energy(never, stacked(c.points), Order::kHessian).value, 0);
  }
}

// Energy and force pass from one kind of place to another without a jump.
TEST(Barrier, ForceIsContinuousBetweenPlaces) {
  const Vec<3> a(0, 0, 0), b(12, 1, 0.5), c(3, 10, -0.3);
  const Barrier barrier{{0, 1, 2, 3}, PairKind::kPointFace, kDistance, kStiffness, kParallel};
  const auto at = [&](const Vec<3>& p) {
    return barrier_energy(barrier, stacked(millimetres(p, a, b, c)), Order::kHessian);
  };
  int changes = 0;
  const Vec<3> from(-1.5, 4, 1), to(14, 0.5, 1);  // over edge, inside, edge, corner
  constexpr int kSteps = 4000;
  for (int i = 0; i < kSteps; ++i) {
    const Vec<3> p = from + (to - from) * i / kSteps, q = from + (to - from) * (i + 1) / kSteps;
    const LocalEnergy<12> here = at(p), there = at(q);
    changes += pair_distance(barrier.kind, millimetres(p, a, b, c)).free !=
               pair_distance(barrier.kind, millimetres(q, a, b, c)).free;
    Vec<12> step = Vec<12>::Zero();
    step.head<3>() = 1e-3 * (q - p);
    const double stiffness = std::max(here.hessian.norm(), there.hessian.norm());
    EXPECT_LE((there.gradient - here.gradient).norm(), 1.1 * stiffness * step.norm() + 1e-12);
    EXPECT_NEAR(there.value - here.value, here.gradient.dot(step),
                1.1 * stiffness * step.squaredNorm() + 1e-15);
  }
  EXPECT_EQ(changes, 3);
}

}  // namespace
}  // namespace pleat::sim
