#include "campaign/run_tasks.h"

#include <gmock/gmock.h>

#include <csignal>
#include <cstdlib>

#include "core/progress.h"
#include "garment/clip.h"
#include "tests/campaign/campaign_files.h"
#include "tests/core/input_error.h"

namespace pleat::campaign {
namespace {

using testing::ElementsAre;
using testing::Pair;

// As a finished chain leaves it: three frames, the second rejected.
void write_shard(const CampaignFiles& files, const Chain& chain) {
  garment::Clip clip;
  clip.design = files.campaign.designs[chain.design];
  clip.motion_name = files.campaign.motions[chain.motion].name;
  clip.shape = files.campaign.shapes[chain.shape];
  for (int t = 0; t < 3; ++t) {
    clip.poses.emplace_back();
    clip.positions.push_back(Points3::Constant(5, 3, t));
    garment::Certificate certificate;
    certificate.is_accepted = t != 1;
    certificate.reason = t == 1 ? "not settled" : "";
    certificate.seconds = 0.25;
    clip.certificates.push_back(certificate);
  }
  std::filesystem::create_directories(files.scratch.path("shards"));
  garment::write_clip(shard_path(files.scratch.path(""), chain.key), clip, chain.key, {});
}

std::vector<std::string> names_in(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.push_back(entry.path().filename().string());
  return names;
}

TEST(RunTasks, LeavesGarmentsThatAreThere) {
  const CampaignFiles files;
  const std::string folder = files.scratch.path("");
  const Manifest manifest = plan(files.campaign);
  std::filesystem::create_directories(files.scratch.path("garments"));
  for (const std::string& key : manifest.garment_keys)
    write_bytes(garment_path(folder, key), "settled before");
  const RunReport report = settle_garments(files.campaign, manifest, folder, 1, 2);
  EXPECT_EQ(report.kept, 2);
  EXPECT_EQ(report.made, 0);
  EXPECT_FALSE(report.is_interrupted);
  for (const std::string& key : manifest.garment_keys)
    EXPECT_EQ(read_bytes(garment_path(folder, key)), "settled before");
}

TEST(RunTasks, LeavesChainsThatAreThereAndCountsTheirFrames) {
  const CampaignFiles files;
  const std::string folder = files.scratch.path("");
  const Manifest manifest = plan(files.campaign);
  for (const Chain& chain : manifest.chains) write_shard(files, chain);
  const std::string before = read_bytes(shard_path(folder, manifest.chains[5].key));
  const RunReport report = run_chains(files.campaign, manifest, folder, 1, 2);
  EXPECT_EQ(report.kept, 8);
  EXPECT_EQ(report.made, 0);
  EXPECT_EQ(report.frames, 24);
  EXPECT_EQ(report.accepted, 16);
  EXPECT_THAT(report.rejected, ElementsAre(Pair("not settled", 8)));
  EXPECT_DOUBLE_EQ(report.drape_seconds, 6);
  EXPECT_EQ(read_bytes(shard_path(folder, manifest.chains[5].key)), before);
}

TEST(RunTasks, NamesTheFileThatIsDamagedOrMissing) {
  const CampaignFiles files;
  const std::string folder = files.scratch.path("");
  const Manifest manifest = plan(files.campaign);
  for (const Chain& chain : manifest.chains) write_shard(files, chain);
  const std::string shard = shard_path(folder, manifest.chains[3].key);
  const std::string bytes = read_bytes(shard);
  write_bytes(shard, bytes.substr(0, bytes.size() / 2));
  EXPECT_INPUT_ERROR(run_chains(files.campaign, manifest, folder, 1, 1), shard);
  std::filesystem::remove(shard);  // its garment was never settled
  EXPECT_INPUT_ERROR(run_chains(files.campaign, manifest, folder, 1, 1),
                     garment_path(folder, manifest.garment_keys[1]));
  EXPECT_EQ(names_in(folder + "/shards").size(), 7u);
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
        const RunReport chains = run_chains(files.campaign, manifest, folder, 1, 2);
        const RunReport garments = settle_garments(files.campaign, manifest, folder, 1, 2);
        const bool is_right = chains.is_interrupted && chains.kept == 1 && chains.made == 0 &&
                              names_in(folder + "/shards").size() == 1 && garments.is_interrupted &&
                              garments.made == 0 && names_in(folder + "/garments").empty();
        std::_Exit(is_right ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace pleat::campaign
