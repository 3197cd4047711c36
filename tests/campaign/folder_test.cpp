// What a campaign's folder tells of itself: status, check and repair, index.
#include "campaign/folder.h"

#include <gmock/gmock.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "campaign/check.h"
#include "campaign/index.h"
#include "campaign/status.h"
#include "core/error.h"
#include "core/hdf5_file.h"
#include "tests/campaign/campaign_files.h"
#include "tests/core/input_error.h"

namespace pleat::campaign {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;
using testing::UnorderedElementsAre;

// A campaign whose eight chains are all there, by hand.
struct Finished : CampaignFiles {
  Manifest manifest = plan(campaign);
  std::string folder = scratch.path("runs");

  Finished() {
    std::filesystem::create_directories(folder + "/garments");
    write_manifest(folder, campaign, manifest);
    write_bytes(folder + "/config.yaml", "designs: []\n");
    for (const std::string& key : manifest.garment_keys) {
      Hdf5File file = Hdf5File::create(garment_path(folder, key));
      file.write("x", std::vector<double>(20, 1.0), {20});
      file.commit();
    }
    for (const Chain& chain : manifest.chains) write_shard(*this, chain, "runs");
  }
  std::string shard(int chain) const { return shard_path(folder, manifest.chains[chain].key); }
  std::string name(int chain) const { return "shards/" + manifest.chains[chain].key + ".h5"; }
};

std::vector<std::string> damages(const std::string& folder) {
  std::vector<std::string> texts;
  for (const Damage& damage : check(folder).damages)
    texts.push_back(damage.file + " " + damage.what);
  return texts;
}

TEST(Folder, CheckNamesEveryKindOfDamageAndRepairSetsItAside) {
  const Finished files;
  EXPECT_THAT(damages(files.folder), ElementsAre());
  EXPECT_EQ(check(files.folder).files, 10);
  std::string bytes = read_bytes(files.shard(0));
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 16);
  write_bytes(files.shard(0), bytes);
  write_bytes(files.shard(1), bytes.substr(0, 1000));
  std::filesystem::remove(files.shard(2));
  std::filesystem::copy_file(files.shard(4), files.shard(3),
                             std::filesystem::copy_options::overwrite_existing);
  const std::string garment = garment_path(files.folder, files.manifest.garment_keys[1]);
  write_bytes(garment, "");
  write_bytes(files.shard(5) + ".tmp-0123", "half");
  write_bytes(files.shard(6) + ".tmp-4567", "of another process, which still writes");
  std::filesystem::last_write_time(
      files.shard(5) + ".tmp-0123",
      std::filesystem::file_time_type::clock::now() - std::chrono::hours(2));
  EXPECT_THAT(damages(files.folder),
              UnorderedElementsAre(files.name(0) + " altered", files.name(1) + " truncated",
                                   files.name(2) + " missing", files.name(3) + " of another chain",
                                   "garments/" + files.manifest.garment_keys[1] + ".h5 truncated",
                                   files.name(5) + ".tmp-0123 left over"));
  repair(files.folder, check(files.folder));
  EXPECT_THAT(damages(files.folder),
              UnorderedElementsAre(files.name(0) + " missing", files.name(1) + " missing",
                                   files.name(2) + " missing", files.name(3) + " missing",
                                   "garments/" + files.manifest.garment_keys[1] + ".h5 missing"));
  EXPECT_EQ(names_in(files.folder + "/set_aside", ".h5").size(), 4u);
  EXPECT_TRUE(std::filesystem::exists(files.shard(6) + ".tmp-4567"));
}

TEST(Folder, StatusCountsChainsAndFrames) {
  const Finished files;
  std::filesystem::remove(files.shard(0));
  std::filesystem::remove(files.shard(1));
  std::filesystem::remove(files.shard(2));
  std::filesystem::create_directories(files.folder + "/failures");
  write_bytes(failure_path(files.folder, files.manifest.chains[0].key),
              R"({"what": "the forces on the cloth are not finite"})");
  std::filesystem::create_directories(parts_path(files.folder, files.manifest.chains[1].key));
  std::filesystem::copy_file(files.shard(3),
                             part_path(files.folder, files.manifest.chains[1].key, 0));
  const Status status = status_of(files.folder);
  EXPECT_EQ(status.chains, 8);
  EXPECT_EQ(status.done, 5);
  EXPECT_EQ(status.under_way, 1);
  EXPECT_EQ(status.frames, 15);
  EXPECT_EQ(status.accepted, 10);
  EXPECT_EQ(status.frames_under_way, 3);
  EXPECT_DOUBLE_EQ(status.drape_seconds, 18 * 0.25);
  EXPECT_THAT(status.rejected, ElementsAre(Pair("not settled", 5)));
  ASSERT_EQ(status.failures.size(), 1u);
  EXPECT_EQ(status.failures[0].key, files.manifest.chains[0].key);
  EXPECT_EQ(status.failures[0].motion, "walk");
  EXPECT_THAT(status.failures[0].what, HasSubstr("not finite"));
  EXPECT_THAT(to_text(status), HasSubstr("5 of 8 done, 1 under way, 1 failed"));
  EXPECT_THAT(to_text(status), HasSubstr("pleat simulate"));
  const nlohmann::json json = nlohmann::json::parse(to_json(status));
  EXPECT_EQ(json["done"], 5);
  EXPECT_EQ(json["rejected"]["not settled"], 5);
  EXPECT_EQ(json["failures"][0]["design"], "tee");
}

TEST(Folder, IndexShowsEveryShard) {
  const Finished files;
  const IndexReport report = write_index(files.folder, {{"not settled"}});
  EXPECT_EQ(report.chains, 8);
  EXPECT_EQ(report.frames, 24);
  EXPECT_EQ(report.accepted, 16);
  EXPECT_THAT(report.rejected, ElementsAre(Pair("not settled", 8)));
  const Hdf5File face = Hdf5File::open(files.folder + "/index.h5");
  const std::vector<std::string> keys = face.read_texts("key");
  ASSERT_EQ(keys.size(), 8u);
  EXPECT_EQ(keys[3], files.manifest.chains[3].key);
  EXPECT_EQ(face.read_texts("design")[3], "dress");
  EXPECT_EQ(face.dims("chains/" + keys[3] + "/positions"), (Dims{3, 5, 3}));
  EXPECT_EQ(face.text_attribute("chains/" + keys[3], "key"), keys[3]);
  const std::string verify =
      "cd '" + files.folder + "' && sha256sum --quiet -c SHA256SUMS >/dev/null 2>&1";
  EXPECT_EQ(std::system(verify.c_str()), 0);
  std::ifstream stream(files.folder + "/croissant.json");
  const nlohmann::json croissant = nlohmann::json::parse(stream);
  EXPECT_EQ(croissant["@type"], "sc:Dataset");
  EXPECT_EQ(croissant["distribution"].size(), 5u + 2u + 8u);
  EXPECT_EQ(croissant["distribution"][14]["sha256"],
            sha256_of_file(files.folder + "/" + files.name(7)));
  EXPECT_THAT(read_bytes(files.folder + "/README.md"), HasSubstr(report.content_hash));
  // Again: the same hash; and what the files say does not change.
  const std::string face_before = read_bytes(files.folder + "/index.h5");
  EXPECT_EQ(write_index(files.folder, {{"any"}}).content_hash, report.content_hash);
  EXPECT_EQ(read_bytes(files.folder + "/index.h5"), face_before);
}

TEST(Folder, IndexRefusesWhatIsNotThereUnlessToldTo) {
  const Finished files;
  EXPECT_INPUT_ERROR(write_index(files.folder, {}), "8 not settled",
                     files.manifest.chains[0].key + ":1", "--accept 'not settled'");
  std::filesystem::remove(files.shard(2));
  EXPECT_INPUT_ERROR(write_index(files.folder, {{"not settled"}}), "1 missing",
                     files.manifest.chains[2].key, "--accept 'missing'");
  std::filesystem::create_directories(files.folder + "/failures");
  write_bytes(failure_path(files.folder, files.manifest.chains[2].key), "{}");
  EXPECT_INPUT_ERROR(write_index(files.folder, {{"not settled", "missing"}}), "1 failed");
  EXPECT_EQ(write_index(files.folder, {{"not settled", "failed"}}).chains, 7);
  std::filesystem::remove(files.folder + "/index.h5");
  std::string bytes = read_bytes(files.shard(3));
  bytes[700] = static_cast<char>(bytes[700] ^ 1);
  write_bytes(files.shard(3), bytes);
  EXPECT_INPUT_ERROR(write_index(files.folder, {{"any"}}),
                     files.manifest.chains[3].key + " altered", "--repair");
  EXPECT_FALSE(std::filesystem::exists(files.folder + "/index.h5"));
}

TEST(Folder, WantsAManifest) {
  const CampaignFiles files;
  for (const auto& action : std::vector<std::function<void(const std::string&)>>{
           [](const std::string& folder) { status_of(folder); },
           [](const std::string& folder) { check(folder); },
           [](const std::string& folder) { write_index(folder, {}); }})
    EXPECT_INPUT_ERROR(action(files.scratch.path("")), "manifest.jsonl");
}

}  // namespace
}  // namespace pleat::campaign
