// A patch on an inclined plane: it stays below the angle of friction, for ever, and slides above.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "tests/validation/scene.h"

namespace pleat::sim {
namespace {

constexpr double kFriction = 0.4;
constexpr double kPatch = 0.15;  // m

// Falls towards +x, with the middle of the patch at the origin.
BodyCollider tilted_slab(const Mat<3>& turn) {
  TriangleMesh box = make_box({0.5, 0.08, 0.4}, 0.02);
  box.vertices.rowwise() -= Eigen::RowVector3d(0.2, 0.08, 0.2);
  box.vertices = (box.vertices * turn.transpose()).eval();
  return {box.vertices, box.faces};
}

// A patch pressed in by its weight.
class OnIncline {
 public:
  explicit OnIncline(double slope)
      : turn_(Eigen::AngleAxisd(-std::atan(slope), Vec<3>::UnitZ()).toRotationMatrix()),
        slab_(tilted_slab(turn_)),
        sheet_(make_grid({kPatch, kPatch}, 10, 10, Diagonal::kAlternating)),
        cloth_(make_cloth(sheet_, garment::Fabric{})) {
    const ContactConfig contact;
    const double pressure = garment::Fabric{}.density_kg_per_m2 * kGravity * turn_(1, 1);
    const double height =
        contact.distance_m -
        std::sqrt(2 * contact.distance_m * pressure / contact.stiffness_N_per_m3);
    start_ = place(sheet_, [&](const Vec<2>& rest) {
      return Vec<3>(turn_ * Vec<3>(rest[0] - kPatch / 2, height, kPatch / 2 - rest[1]));
    });
    state_ = at_rest(start_);
  }

  NewtonResult settle_for(int iterations) {
    return settle(cloth_, {slab_, kFriction, {}, {1e-3, iterations, 0.01}}, state_);
  }
  // The patch's mean way from its start, m.
  Vec<3> way() const {
    return as_rows(state_.x - start_).colwise().mean().transpose();
  }
  Vec<3> downhill() const { return turn_.col(0); }
  void nudge(RandomStream& random, double far) {
    for (double& x : state_.x) x += far * (2 * random.uniform() - 1);
  }

 private:
  Mat<3> turn_;
  BodyCollider slab_;
  Sheet sheet_;
  Cloth cloth_;
  Eigen::VectorXd start_;
  DrapeState state_;
};

TEST(Incline, HoldsBelowTheAngleOfFriction) {
  for (const double share : {0.9, 0.99}) {
    OnIncline patch(share * kFriction);
    const NewtonResult result = patch.settle_for(100);
    const double slipped = patch.way().dot(patch.downhill());
    report("slope " + std::to_string(share) + " mu: slipped", 1000 * slipped, "mm");
    report("  residual", result.residual, "");
    report("  iterations", result.iterations, "");
    EXPECT_TRUE(result.has_converged);
    EXPECT_LE(std::abs(slipped), 1e-4);  // the spring of sticking gives 0.01 mm
  }
}

// What slides finds no equilibrium: the solver follows it downhill and says that it did not settle.
// Short by what friction cannot hold, no less, while the sheet is flat; later it is not.
TEST(Incline, SlidesAboveTheAngleOfFriction) {
  for (const double share : {1.01, 1.1}) {
    OnIncline patch(share * kFriction);
    double residual = 1;
    for (int i = 0; i < 5; ++i) residual = std::min(residual, patch.settle_for(1).residual);
    const double slope = share * kFriction;
    const double excess = (slope - kFriction) / std::sqrt(1 + slope * slope);  // over the weight
    const bool has_converged = patch.settle_for(20).has_converged;
    const double slipped = patch.way().dot(patch.downhill());
    report("slope " + std::to_string(share) + " mu: residual / what friction cannot hold",
           residual / excess, "");
    report("  slipped in 25 iterations", 1000 * slipped, "mm");
    EXPECT_NEAR(residual, excess, 0.02 * excess);
    EXPECT_FALSE(has_converged);
    EXPECT_GE(slipped, 0.002);
  }
}

// Solved again and again, and pushed about by 0.1 mm in between, as a moving body would.
TEST(Incline, NeverCreeps) {
  for (const double nudge : {0.0, 1e-4}) {
    OnIncline patch(0.9 * kFriction);
    ASSERT_TRUE(patch.settle_for(100).has_converged);
    const Vec<3> first = patch.way();
    RandomStream random(1, "incline");
    int converged = 0;
    for (int i = 0; i < 50; ++i) {
      patch.nudge(random, nudge);
      converged += patch.settle_for(100).has_converged;
    }
    const double crept = (patch.way() - first).dot(patch.downhill());
    report("crept in 50 drapes, nudged by " + std::to_string(1000 * nudge) + " mm", 1000 * crept,
           "mm");
    EXPECT_EQ(converged, 50);
    EXPECT_LE(std::abs(crept), nudge > 0 ? 1e-5 : 1e-9);
  }
}

}  // namespace
}  // namespace pleat::sim
