#include "body/motion.h"

#include <gtest/gtest.h>

#include <limits>

#include "body/amass_file.h"
#include "body/rotation.h"
#include "body/skinning.h"
#include "tests/body/synthetic_body.h"
#include "tests/core/input_error.h"
#include "tests/core/scratch.h"

namespace pleat::body {
namespace {

constexpr double kDegree = M_PI / 180;

// Every joint turns about its own axis at its own constant speed, past 180 degrees.
Motion turning(double rate, double seconds) {
  Motion motion{"turning", rate, {}};
  const int frames = static_cast<int>(std::round(seconds * rate)) + 1;
  for (int k = 0; k < frames; ++k) {
    Pose pose;
    for (int j = 0; j < kJoints; ++j) {
      const Vec<3> axis = Vec<3>(1, 0.3 * j, -0.2 * j).normalized();
      pose.rotations.row(j) = axis_angle(rotation_matrix((1.0 + 0.1 * j) * k / rate * axis));
    }
    pose.translation << 0.5 * k / rate, 1, -0.25 * k / rate;
    motion.frames.push_back(pose);
  }
  return motion;
}

double largest_angle(const Motion& a, const Motion& b) {
  double largest = 0;
  for (size_t k = 0; k < a.frames.size(); ++k) {
    for (int j = 0; j < kJoints; ++j) {
      largest = std::max(largest,
                         angle_between(a.frames[k].rotations.row(j), b.frames[k].rotations.row(j)));
    }
  }
  return largest;
}

TEST(Resample, IsExactOnConstantTurning) {
  for (const double rate : {30.0, 50.0, 240.0}) {
    const Motion resampled = resample(turning(120, 2), rate), expected = turning(rate, 2);
    ASSERT_EQ(resampled.frames.size(), expected.frames.size());
    EXPECT_EQ(resampled.frame_rate_hz, rate);
    EXPECT_LT(largest_angle(resampled, expected), 1e-6);  // acos near 1 in angularDistance
    for (size_t k = 0; k < expected.frames.size(); ++k) {
      EXPECT_LT((resampled.frames[k].translation - expected.frames[k].translation).norm(), 1e-12);
    }
  }
}

TEST(Resample, SameRateChangesNothing) {
  const Motion motion = turning(60, 1), same = resample(motion, 60);
  ASSERT_EQ(same.frames.size(), motion.frames.size());
  for (size_t k = 0; k < motion.frames.size(); ++k)
    EXPECT_EQ(same.frames[k].rotations, motion.frames[k].rotations);
}

TEST(Blend, EndsAreExact) {
  RandomStream random(6, "blend");
  const Pose a = random_pose(random, 0.5), b = random_pose(random, 0.5);
  EXPECT_EQ(blend(a, b, 0).rotations, a.rotations);
  EXPECT_EQ(blend(a, b, 1).rotations, b.rotations);
  EXPECT_EQ(blend(a, b, 1).translation, b.translation);
}

TEST(RepairGlitches, BridgesAShortFlip) {
  Motion motion = turning(30, 1);
  const Motion good = motion;
  for (int k = 12; k < 15; ++k) {
    const Mat<3> flipped =
        rotation_matrix(motion.frames[k].rotations.row(2)) * rotation_matrix({0, M_PI, 0});
    motion.frames[k].rotations.row(2) = axis_angle(flipped);
  }
  EXPECT_EQ(repair_glitches(motion, 75, "file"), 1);
  EXPECT_LT(largest_angle(motion, good),
            1e-6);  // the turning is constant, so the bridge is the motion itself
}

TEST(RepairGlitches, RefusesAFlipThatStays) {
  Motion motion = turning(30, 1);
  for (size_t k = 12; k < motion.frames.size(); ++k) {
    const Mat<3> flipped =
        rotation_matrix(motion.frames[k].rotations.row(2)) * rotation_matrix({0, M_PI, 0});
    motion.frames[k].rotations.row(2) = axis_angle(flipped);
  }
  EXPECT_INPUT_ERROR(repair_glitches(motion, 75, "dance.bvh", 100), "dance.bvh", "right_hip",
                     "frame 112");
}

TEST(RepairGlitches, LeavesWristsAndFeetAlone) {
  Motion motion = turning(30, 1);
  const Points3 before = motion.frames[12].rotations;
  for (int j : {7, 10, 20, 21}) motion.frames[12].rotations.row(j) << 0, 3, 0;
  EXPECT_EQ(repair_glitches(motion, 75, "file"), 0);
  EXPECT_NE(motion.frames[12].rotations, before);
}

// The limit is a speed: 75 degrees in a thirtieth of a second are 18.75 in a frame at 120 Hz.
TEST(RepairGlitches, LimitFollowsTheFrameRate) {
  for (const auto& [jump, glitches] : {std::pair<double, int>{15, 0}, {25, 1}}) {
    Motion motion{"still", 120, std::vector<Pose>(20)};
    motion.frames[10].rotations.row(4) << jump * kDegree, 0, 0;
    EXPECT_EQ(repair_glitches(motion, 75, "file"), glitches);
  }
}

TEST(LeadingTPoses, AreCalibrationOnlyBeforeAJump) {
  Pose hanging;
  hanging.rotations.row(16) << 0, 0, -1.3;
  hanging.rotations.row(17) << 0, 0, 1.3;
  Motion jumps{"jumps", 30, {Pose(), Pose(), hanging, hanging}};
  EXPECT_EQ(leading_t_poses(jumps, 70), 2);
  Motion eases{"eases", 30, {}};
  for (int k = 0; k <= 10; ++k) eases.frames.push_back(blend(Pose(), hanging, k / 10.0));
  EXPECT_EQ(leading_t_poses(eases, 70), 0);
  EXPECT_EQ(leading_t_poses({"t", 30, {Pose(), Pose()}}, 70), 0);
}

class LoadMotion : public testing::Test {
 protected:
  LoadMotion() : model_(box_body()) {
    root_ = shape_body(model_, Eigen::VectorXd()).joints.row(0);
    for (Pose& pose : motion_.frames) pose.rotations.bottomRows(2).setZero();
  }
  std::string write() {
    write_amass(scratch_.path("turning.npz"), motion_, root_);
    return scratch_.path("turning.npz");
  }
  Scratch scratch_;
  BodyModel model_;
  Vec<3> root_;
  Motion motion_ = turning(120, 2);
};

TEST_F(LoadMotion, CutsAndResamples) {
  MotionConfig config;
  config.ground = false;
  config.start_s = 0.51;  // between two frames
  config.duration_s = 1;
  const Motion motion = load_motion(write(), model_, config);
  ASSERT_EQ(motion.frames.size(), 31u);
  EXPECT_NEAR(motion.frames[0].translation.x(), 0.5 * 0.51, 1e-9);
  EXPECT_NEAR(motion.frames[30].translation.x(), 0.5 * 1.51, 1e-9);
  config.start_s = 3;
  EXPECT_INPUT_ERROR(load_motion(write(), model_, config), "turning.npz", "motion.start_s = 3",
                     "2 s");
}

TEST_F(LoadMotion, GroundsTheLowestFootVertex) {
  const Motion motion = load_motion(write(), model_, {});
  const ShapedBody body = shape_body(model_, Eigen::VectorXd());
  EXPECT_NEAR(lowest_foot_height(motion, model_, body), 0, 1e-12);
  double lowest =
      std::numeric_limits<double>::infinity();  // over the whole body, feet picked out here
  for (const Pose& pose : motion.frames) {
    const Points3 posed = pose_body(model_, body, pose);
    for (int v = 0; v < posed.rows(); ++v) {
      double weight = 0;
      for (int j : {7, 8, 10, 11}) weight += model_.weights.coeff(v, j);
      if (weight > 0.5) lowest = std::min(lowest, posed(v, 1));
    }
  }
  EXPECT_NEAR(lowest, 0, 1e-12);
}

TEST_F(LoadMotion, OnlyTheCutMustBeFreeOfGlitches) {
  for (size_t k = 200; k < motion_.frames.size(); ++k)
    motion_.frames[k].rotations.row(9) << 0, 3, 0;
  EXPECT_INPUT_ERROR(load_motion(write(), model_, {}), "spine3", "frame 200");
  MotionConfig config;
  config.duration_s = 1.5;
  EXPECT_EQ(load_motion(write(), model_, config).frames.size(), 46u);
}

TEST_F(LoadMotion, InfoTellsWhatLoadingDoes) {
  const MotionInfo info = motion_info(write(), model_, {});
  EXPECT_EQ(info.frames, 241);
  EXPECT_EQ(info.frame_rate_hz, 120);
  EXPECT_DOUBLE_EQ(info.seconds, 2);
  EXPECT_EQ(info.problem, "");
  EXPECT_EQ(info.glitches_repaired, 0);
  EXPECT_EQ(info.max_step_joint,
            "right_elbow");  // 2.9 rad/s, the fastest of those that are checked
  EXPECT_NEAR(info.max_joint_step_deg, 2.9 / 30 / kDegree, 1e-4);
  EXPECT_NEAR(info.path_length_m, 2 * std::hypot(0.5, 0.25), 1e-3);

  for (size_t k = 200; k < motion_.frames.size(); ++k)
    motion_.frames[k].rotations.row(9) << 0, 3, 0;
  EXPECT_NE(motion_info(write(), model_, {}).problem.find("spine3"), std::string::npos);
}

TEST_F(LoadMotion, RefusesUnknownKindsAndBadConfig) {
  EXPECT_INPUT_ERROR(load_motion("dance.fbx", model_, {}), "dance.fbx", ".npz", ".bvh");
  MotionConfig config;
  config.frame_rate_hz = 0;
  EXPECT_INPUT_ERROR(validate(config), "motion.frame_rate_hz = 0");
  config = {};
  config.start_s = std::nan("");
  EXPECT_INPUT_ERROR(validate(config), "motion.start_s");
}

}  // namespace
}  // namespace pleat::body
