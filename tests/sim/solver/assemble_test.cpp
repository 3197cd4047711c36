#include "sim/solver/assemble.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "measured_fabrics.h"
#include "tests/sim/dressed_ball.h"

namespace pleat::sim {
namespace {

// Central differences of 1e-9 m along a random direction: what is left of the step is 1e-6 of the
// stiffness, of barriers of a few tenths of a millimetre 1e-5, and of rounding less.
TEST(Assemble, GradientAndHessianAreDerivativesOfTheEnergy) {
  garment::Fabric neo_hookean;
  neo_hookean.membrane = garment::MembraneModel::kNeoHookean;
  for (const garment::Fabric& fabric :
       {garment::Fabric{}, neo_hookean, measured_fabric("gray_interlock")}) {
    DressedBall scene(fabric);
    const Held held(scene, whole(scene.cloth));
    ASSERT_GT(held.touching.contacts.size(), 50u);
    ASSERT_GT(held.touching.frictions.size(), 50u);
    ASSERT_GT(held.elements.size(), 100u);
    const Eigen::VectorXd direction = random_vector(scene.x.size(), "direction");
    const double h = 1e-9;
    const System at = held.system(scene.x, Order::kHessian);
    const System up = held.system(scene.x + h * direction, Order::kGradient);
    const System down = held.system(scene.x - h * direction, Order::kGradient);
    EXPECT_NEAR((up.energy - down.energy) / (2 * h), at.gradient.dot(direction),
                1e-6 * at.gradient.norm() * direction.norm());
    const Eigen::MatrixXd hessian = dense(at.hessian);
    Eigen::VectorXd product = hessian * direction;
    for (const ActiveBarrier& barrier : held.barriers(scene.x, Order::kHessian)) {
      PairPoints local = PairPoints::Zero();  // the Hessian leaves the barriers out
      for (int k = 0; k < 4; ++k)
        if (barrier.element.vertices[k] < scene.cloth.vertex_count)
          local.col(k) = direction.segment<3>(3 * barrier.element.vertices[k]);
      const PairPoints change = hessian_product(barrier.term, local);
      for (int k = 0; k < 4; ++k)
        if (barrier.element.vertices[k] < scene.cloth.vertex_count)
          product.segment<3>(3 * barrier.element.vertices[k]) += change.col(k);
    }
    EXPECT_LE(((up.gradient - down.gradient) / (2 * h) - product).norm(), 1e-5 * product.norm());
    EXPECT_LE((hessian - hessian.transpose()).norm(), 1e-14 * hessian.norm());
  }
}

TEST(Assemble, ProjectedHessianIsPositive) {
  for (const garment::Fabric& fabric : {garment::Fabric{}, measured_fabric("gray_interlock")}) {
    DressedBall scene(fabric);
    shake(scene.x, 1e-3, "crumple");  // so that the exact one is not
    const Held held(scene, whole(scene.cloth));
    const auto smallest = [&](Order order) {
      const Eigen::MatrixXd hessian = dense(held.system(scene.x, order).hessian);
      return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(hessian).eigenvalues()[0] /
             hessian.norm();
    };
    EXPECT_GE(smallest(Order::kProjectedHessian), -1e-14);
    EXPECT_LT(smallest(Order::kHessian), -1e-6);
  }
}

TEST(Assemble, LowerOrdersGiveTheSame) {
  DressedBall scene;
  const Held held(scene, whole(scene.cloth));
  const System full = held.system(scene.x, Order::kHessian);
  EXPECT_EQ(held.system(scene.x, Order::kValue).energy, full.energy);
  EXPECT_EQ(held.system(scene.x, Order::kGradient).gradient, full.gradient);
}

// What was in the system before does not show.
TEST(Assemble, StartsAfresh) {
  DressedBall scene;
  const Held held(scene, whole(scene.cloth));
  const System expected = held.system(scene.x, Order::kHessian);
  Eigen::VectorXd elsewhere = scene.x;
  shake(elsewhere, 1e-3, "elsewhere");
  System system = held.system(elsewhere, Order::kHessian);
  assemble(scene.cloth, held.region, held.touching, held.barriers(scene.x, Order::kHessian),
           scene.x, Order::kHessian, system);
  EXPECT_EQ(system.energy, expected.energy);
  EXPECT_EQ(system.gradient, expected.gradient);
  EXPECT_EQ(system.hessian.values, expected.hessian.values);
}

TEST(Assemble, RegionHasItsShareOfTheWhole) {
  for (const garment::Fabric& fabric : {garment::Fabric{}, measured_fabric("gray_interlock")}) {
    DressedBall scene(fabric);
    const Held all(scene, whole(scene.cloth));
    const Region region = around(scene.cloth, {9, 20}, 1);
    ASSERT_LT(region.vertices.size(), scene.cloth.vertex_count / 2u);
    const Held part(scene, region);
    const System of_all = all.system(scene.x, Order::kHessian);
    const System of_part = part.system(scene.x, Order::kHessian);
    for (const int v : region.vertices) {
      // Sums of the same elements, barriers in another order.
      EXPECT_LE((of_part.gradient - of_all.gradient).segment<3>(3 * v).norm(),
                1e-14 * of_all.gradient.norm());
      for (int k = of_all.hessian.row_start[v]; k < of_all.hessian.row_start[v + 1]; ++k)
        EXPECT_EQ(of_part.hessian.block(k), of_all.hessian.block(k));
    }
    // As its vertices move, its energy changes by what the whole one's does.
    Eigen::VectorXd moved = scene.x;
    const Eigen::VectorXd way = 1e-5 * random_vector(moved.size(), "way");
    for (const int v : region.vertices) moved.segment<3>(3 * v) += way.segment<3>(3 * v);
    const double change = all.system(moved, Order::kValue).energy - of_all.energy;
    EXPECT_GT(std::abs(change), 1e-9);
    EXPECT_NEAR(part.system(moved, Order::kValue).energy - of_part.energy, change,
                1e-13 * std::abs(of_all.energy) + 1e-12);
  }
}

TEST(Assemble, PinnedVerticesFeelNoForce) {
  DressedBall scene;
  const System loose = Held(scene, whole(scene.cloth)).system(scene.x, Order::kGradient);
  scene.cloth.is_pinned.assign(scene.cloth.vertex_count, 0);
  scene.cloth.is_pinned[5] = 1;
  const System pinned = Held(scene, whole(scene.cloth)).system(scene.x, Order::kGradient);
  EXPECT_GT(loose.gradient.segment<3>(15).norm(), 0);
  EXPECT_EQ(pinned.gradient.segment<3>(15).norm(), 0);
  Eigen::VectorXd expected = loose.gradient;
  expected.segment<3>(15).setZero();
  EXPECT_EQ(pinned.gradient, expected);
}

// ---- Regions

void expect_consistent(const Cloth& cloth, const Region& region) {
  EXPECT_TRUE(std::is_sorted(region.vertices.begin(), region.vertices.end()));
  ASSERT_EQ(region.place.size(), static_cast<size_t>(cloth.vertex_count));
  int inside = 0;
  for (int v = 0; v < cloth.vertex_count; ++v) {
    if (region.place[v] < 0) continue;
    ++inside;
    EXPECT_EQ(region.vertices[region.place[v]], v);
  }
  EXPECT_EQ(region.vertices.size(), static_cast<size_t>(inside));
  const auto touching = [&](const auto& elements) {
    std::vector<int> result;
    for (size_t e = 0; e < elements.size(); ++e)
      for (const int v : elements[e].vertices)
        if (region.place[v] >= 0) {
          result.push_back(static_cast<int>(e));
          break;
        }
    return result;
  };
  EXPECT_EQ(region.membranes, touching(cloth.membranes));
  EXPECT_EQ(region.bendings, touching(cloth.bendings));
}

TEST(Region, WholeHasEverything) {
  const DressedBall scene;
  const Region region = whole(scene.cloth);
  expect_consistent(scene.cloth, region);
  EXPECT_EQ(region.vertices.size(), static_cast<size_t>(scene.cloth.vertex_count));
  EXPECT_EQ(region.membranes.size(), scene.cloth.membranes.size());
  EXPECT_EQ(region.bendings.size(), scene.cloth.bendings.size());
}

// Breadth first over faces and hinges: one step of the pattern joins the corners of two faces that
// share an edge.
TEST(Region, AroundGoesSoManySteps) {
  const DressedBall scene;
  std::set<int> expected = {3, 40};
  for (int steps = 0; steps < 4; ++steps) {
    const Region region = around(scene.cloth, {40, 3}, steps);
    expect_consistent(scene.cloth, region);
    EXPECT_EQ(region.vertices, std::vector<int>(expected.begin(), expected.end())) << steps;
    std::set<int> next = expected;
    for (const Bending& bending : scene.cloth.bendings)
      if (std::any_of(bending.vertices.begin(), bending.vertices.end(),
                      [&](int v) { return expected.count(v) > 0; }))
        next.insert(bending.vertices.begin(), bending.vertices.end());
    expected = next;
  }
  EXPECT_LT(*expected.rbegin(), DressedBall::kLayer);  // never the other layer
}

}  // namespace
}  // namespace pleat::sim
