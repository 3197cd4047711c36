#include "body/amass_file.h"

#include <gtest/gtest.h>

#include <limits>

#include "body/rotation.h"
#include "tests/body/archive.h"
#include "tests/body/synthetic_body.h"
#include "tests/core/input_error.h"
#include "tests/core/scratch.h"

namespace pleat::body {
namespace {

const Vec<3> kRoot(0.01, -0.22, 0.03);  // where SMPL has its pelvis

Motion some_motion() {
  RandomStream random(4, "motion");
  Motion motion{"walk", 120, {}};
  for (int k = 0; k < 5; ++k) {
    motion.frames.push_back(random_pose(random, 0.4));
    motion.frames.back().rotations.bottomRows(2).setZero();
  }
  return motion;
}

TEST(AmassFile, GivesBackWhatWasWritten) {
  const Scratch scratch;
  const Motion motion = some_motion();
  write_amass(scratch.path("walk.npz"), motion, kRoot);
  const Motion read = read_amass(scratch.path("walk.npz"), kRoot);
  EXPECT_EQ(read.name, "walk");
  EXPECT_EQ(read.frame_rate_hz, 120);
  ASSERT_EQ(read.frames.size(), motion.frames.size());
  for (size_t k = 0; k < motion.frames.size(); ++k) {
    EXPECT_LT((read.frames[k].rotations - motion.frames[k].rotations).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LT((read.frames[k].translation - motion.frames[k].translation).norm(), 1e-12);
  }
  const NpzFile file(scratch.path("walk.npz"));
  EXPECT_EQ(file.shape("poses"), (std::vector<int64_t>{5, 156}));
  EXPECT_EQ(file.read_text("gender"), "neutral");
}

// A figure that stands upright in AMASS's z-up world (root turned +90 degrees about x), pelvis 0.9
// m above the floor and 2 m to the front, stands upright in ours, facing +z.
TEST(AmassFile, TurnsZUpToYUp) {
  const Scratch scratch;
  const std::string path = scratch.path("stand.npz");
  write_amass(path, some_motion(), kRoot);
  std::vector<NpzEntry> entries = entries_of(path);
  NpyArray& poses = array_of(entries, "poses");
  poses = {{1, 156}, std::vector<double>(156, 0.0)};
  poses.values[0] = M_PI / 2;
  const Vec<3> pelvis(0.3, -2, 0.9);  // x left, y back, z up
  const Vec<3> translation = pelvis - kRoot;
  array_of(entries, "trans") = {{1, 3}, {translation[0], translation[1], translation[2]}};
  write_npz(path, entries);
  const Motion motion = read_amass(path, kRoot);
  ASSERT_EQ(motion.frames.size(), 1u);
  EXPECT_LT(motion.frames[0].rotations.norm(), 1e-12);
  EXPECT_LT((motion.frames[0].translation + kRoot - Vec<3>(0.3, 0.9, 2)).norm(), 1e-12);
}

TEST(AmassFile, ReadsTheSmplxGeneration) {
  const Scratch scratch;
  const std::string path = scratch.path("walk_stageii.npz");
  const Motion motion = some_motion();
  write_amass(path, motion, kRoot);
  std::vector<NpzEntry> entries = entries_of(path);
  NpyArray& poses = array_of(entries, "poses");
  NpyArray wide{{5, 165},
                std::vector<double>(
                    5 * 165, 0.7)};  // face and fingers move; they must not reach the 24 joints
  NpyArray root{{5, 3}, {}}, rest{{5, 63}, {}};
  for (int k = 0; k < 5; ++k) {
    std::copy_n(poses.values.begin() + 156 * k, 66, wide.values.begin() + 165 * k);
    root.values.insert(root.values.end(), poses.values.begin() + 156 * k,
                       poses.values.begin() + 156 * k + 3);
    rest.values.insert(rest.values.end(), poses.values.begin() + 156 * k + 3,
                       poses.values.begin() + 156 * k + 66);
  }
  poses = wide;
  remove_entry(entries, "mocap_framerate");
  remove_entry(entries, "gender");
  entries.push_back({"mocap_frame_rate", "<f8", {{}, {120.00004577}}, ""});
  for (const bool has_poses : {true, false}) {
    if (!has_poses) {
      remove_entry(entries, "poses");
      entries.push_back({"root_orient", "<f8", root, ""});
      entries.push_back({"pose_body", "<f8", rest, ""});
    }
    write_npz(path, entries);
    add_raw(path, "gender", "|S6", "female");
    add_raw(path, "labels_obs", "|O", "\x80\x03]q.");
    const Motion read = read_amass(path, kRoot);
    EXPECT_EQ(read.frame_rate_hz, 120);
    ASSERT_EQ(read.frames.size(), 5u);
    for (int k = 0; k < 5; ++k) {
      EXPECT_LT((read.frames[k].rotations - motion.frames[k].rotations).cwiseAbs().maxCoeff(),
                1e-9);
    }
  }
}

TEST(AmassFile, NamesFileArrayAndFrameAtFault) {
  const Scratch scratch;
  const std::string good = scratch.path("good.npz"), bad = scratch.path("bad.npz");
  write_amass(good, some_motion(), kRoot);
  std::vector<NpzEntry> entries = entries_of(good);
  array_of(entries, "poses").values[156 * 3 + 40] = std::numeric_limits<double>::quiet_NaN();
  write_npz(bad, entries);
  EXPECT_INPUT_ERROR(read_amass(bad, kRoot), "bad.npz", "poses", "frame 3");
  entries = entries_of(good);
  array_of(entries, "trans").values[3 * 2] = std::numeric_limits<double>::infinity();
  write_npz(bad, entries);
  EXPECT_INPUT_ERROR(read_amass(bad, kRoot), "bad.npz", "trans", "frame 2");
  entries = entries_of(good);
  array_of(entries, "trans") = {{4, 3}, std::vector<double>(12, 0.0)};
  write_npz(bad, entries);
  EXPECT_INPUT_ERROR(read_amass(bad, kRoot), "bad.npz", "trans is 4 x 3", "5 x 3");
  entries = entries_of(good);
  array_of(entries, "poses") = {{5, 60}, std::vector<double>(300, 0.0)};
  write_npz(bad, entries);
  EXPECT_INPUT_ERROR(read_amass(bad, kRoot), "bad.npz", "poses is 5 x 60");
  entries = entries_of(good);
  array_of(entries, "poses") = {{0, 156}, {}};
  write_npz(bad, entries);
  EXPECT_INPUT_ERROR(read_amass(bad, kRoot), "bad.npz", "no frames");
  for (const char* key : {"poses", "trans", "mocap_framerate"}) {
    entries = entries_of(good);
    remove_entry(entries, key);
    write_npz(bad, entries);
    EXPECT_INPUT_ERROR(read_amass(bad, kRoot), "bad.npz", key);
  }
  entries = entries_of(good);
  array_of(entries, "mocap_framerate").values[0] = 0;
  write_npz(bad, entries);
  EXPECT_INPUT_ERROR(read_amass(bad, kRoot), "bad.npz", "mocap_framerate");
}

}  // namespace
}  // namespace pleat::body
