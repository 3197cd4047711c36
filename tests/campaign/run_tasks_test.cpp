#include "campaign/run_tasks.h"

#include <gmock/gmock.h>

#include <csignal>
#include <cstdlib>
#include <limits>

#include "core/error.h"
#include "core/hdf5_file.h"
#include "core/progress.h"
#include "garment/clip.h"
#include "tests/campaign/campaign_files.h"
#include "tests/core/input_error.h"

namespace pleat::campaign {
namespace {

using testing::ElementsAre;
using testing::Pair;

RunOptions options_of(const CampaignFiles& files, int threads = 1) {
  RunOptions options;
  options.folder = files.scratch.path("");
  options.threads = threads;
  return options;
}

TEST(RunTasks, LeavesGarmentsThatAreThere) {
  const CampaignFiles files;
  const std::string folder = files.scratch.path("");
  const Manifest manifest = plan(files.campaign);
  std::filesystem::create_directories(files.scratch.path("garments"));
  for (const std::string& key : manifest.garment_keys) {
    Hdf5File file = Hdf5File::create(garment_path(folder, key));
    file.write_attribute("/", "settled", "before");
    file.commit();
  }
  const RunReport report = settle_garments(files.campaign, manifest, options_of(files, 2));
  EXPECT_EQ(report.kept, 2);
  EXPECT_EQ(report.made, 0);
  EXPECT_FALSE(report.is_interrupted);
  for (const std::string& key : manifest.garment_keys)
    EXPECT_EQ(Hdf5File::open(garment_path(folder, key)).text_attribute("/", "settled"), "before");
}

TEST(RunTasks, LeavesChainsThatAreThereAndCountsTheirFrames) {
  const CampaignFiles files;
  const std::string folder = files.scratch.path("");
  const Manifest manifest = plan(files.campaign);
  for (const Chain& chain : manifest.chains) write_shard(files, chain);
  const std::string before = read_bytes(shard_path(folder, manifest.chains[5].key));
  RunOptions options = options_of(files, 2);
  const RunReport report = run_chains(files.campaign, manifest, options);
  EXPECT_EQ(report.kept, 8);
  EXPECT_EQ(report.made, 0);
  EXPECT_EQ(report.frames, 24);
  EXPECT_EQ(report.accepted, 16);
  EXPECT_THAT(report.rejected, ElementsAre(Pair("not settled", 8)));
  EXPECT_DOUBLE_EQ(report.drape_seconds, 6);
  EXPECT_EQ(read_bytes(shard_path(folder, manifest.chains[5].key)), before);
  options.slice = {2, 3};  // rows 2 and 5
  EXPECT_EQ(run_chains(files.campaign, manifest, options).kept, 2);
}

TEST(RunTasks, LeavesChainsThatFailed) {
  const CampaignFiles files;
  const Manifest manifest = plan(files.campaign);
  for (size_t c = 1; c < manifest.chains.size(); ++c) write_shard(files, manifest.chains[c]);
  std::filesystem::create_directories(files.scratch.path("failures"));
  write_bytes(failure_path(files.scratch.path(""), manifest.chains[0].key), "{}");
  const RunReport report = run_chains(files.campaign, manifest, options_of(files));
  EXPECT_EQ(report.kept, 7);
  EXPECT_EQ(report.failed, 1);
  // And those whose design does not settle, which is not tried again either.
  const int dress = manifest.chains[2].design;
  std::filesystem::remove(shard_path(files.scratch.path(""), manifest.chains[2].key));
  for (size_t d = 0; d < manifest.garment_keys.size(); ++d)
    write_bytes(failure_path(files.scratch.path(""), manifest.garment_keys[d]), "{}");
  EXPECT_NE(dress, manifest.chains[0].design);
  EXPECT_EQ(settle_garments(files.campaign, manifest, options_of(files)).failed, 2);
  EXPECT_EQ(run_chains(files.campaign, manifest, options_of(files)).failed, 2);
}

// A damaged shard is made again: here that stops for want of its garment, which is named.
TEST(RunTasks, SetsDamagedShardsAside) {
  const CampaignFiles files;
  const std::string folder = files.scratch.path("");
  const Manifest manifest = plan(files.campaign);
  for (const Chain& chain : manifest.chains) write_shard(files, chain);
  const std::string shard = shard_path(folder, manifest.chains[3].key);
  const std::string bytes = read_bytes(shard);
  write_bytes(shard, bytes.substr(0, bytes.size() / 2));
  EXPECT_INPUT_ERROR(run_chains(files.campaign, manifest, options_of(files)),
                     garment_path(folder, manifest.garment_keys[1]));
  EXPECT_EQ(names_in(folder + "/shards", ".h5").size(), 7u);
  EXPECT_EQ(names_in(folder + "/set_aside", ".h5").size(), 1u);
  EXPECT_EQ(read_bytes(folder + "/set_aside/1_" + manifest.chains[3].key + ".h5").size(),
            bytes.size() / 2);
}

TEST(RunTasks, WantsRoomBeforeItStarts) {
  const CampaignFiles files;
  const Manifest manifest = plan(files.campaign);
  RunOptions options = options_of(files);
  options.limits.min_free_disk_mb = std::numeric_limits<int>::max();  // 2,000 TB
  try {
    run_chains(files.campaign, manifest, options);
    ADD_FAILURE() << "ran";
  } catch (const ResourceError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("limits.min_free_disk_mb"));
  }
}

TEST(RunTasks, ChecksInputsBeforeWork) {
  const CampaignFiles files;
  EXPECT_NO_THROW(check_inputs(files.campaign));
  Campaign campaign = files.campaign;
  campaign.shapes[1] = Eigen::VectorXd::Zero(4);  // the box has three directions
  EXPECT_INPUT_ERROR(check_inputs(campaign), "4", "3");
  campaign = files.campaign;
  campaign.motions[1].config.start_s = 9;
  EXPECT_INPUT_ERROR(check_inputs(campaign), "jump.npz", "start_s = 9");
  write_bytes(campaign.motions[0].file, "PK");
  EXPECT_INPUT_ERROR(check_inputs(campaign), "walk.npz");
  write_bytes(campaign.body_file, "PK");
  EXPECT_INPUT_ERROR(check_inputs(campaign), "body.npz");
}

TEST(RunTasks, InterruptedRunSaysSoAndLeavesNoPart) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        const CampaignFiles files;
        const std::string folder = files.scratch.path("");
        const Manifest manifest = plan(files.campaign);
        write_shard(files, manifest.chains[0]);
        catch_interrupts();
        std::raise(SIGINT);
        const RunReport chains = run_chains(files.campaign, manifest, options_of(files, 2));
        const RunReport garments = settle_garments(files.campaign, manifest, options_of(files, 2));
        const bool is_right = chains.is_interrupted && chains.kept == 1 && chains.made == 0 &&
                              names_in(folder + "/shards", ".h5").size() == 1 &&
                              garments.is_interrupted && garments.made == 0 &&
                              names_in(folder + "/garments", ".h5").empty();
        std::_Exit(is_right ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace pleat::campaign
