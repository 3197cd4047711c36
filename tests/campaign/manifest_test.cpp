#include "campaign/manifest.h"

#include <gmock/gmock.h>

#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/campaign/campaign_files.h"
#include "tests/core/input_error.h"

namespace pleat::campaign {
namespace {

// "motion/design/shape" -> key; of garments "design" -> key.
using Keys = std::map<std::string, std::string>;

Keys keys_of(const Campaign& campaign) {
  const Manifest manifest = plan(campaign);
  Keys keys;
  for (size_t d = 0; d < campaign.designs.size(); ++d)
    keys[campaign.designs[d].name] = manifest.garment_keys.at(d);
  for (const Chain& chain : manifest.chains)
    keys[campaign.motions.at(chain.motion).name + "/" + campaign.designs.at(chain.design).name +
         "/" + std::to_string(chain.shape)] = chain.key;
  return keys;
}

// Names whose keys differ between two plans, or which only one of them has.
std::set<std::string> changed(const Keys& before, const Keys& after) {
  std::set<std::string> names;
  for (const auto& [name, key] : before)
    if (after.count(name) == 0 || after.at(name) != key) names.insert(name);
  for (const auto& [name, key] : after)
    if (before.count(name) == 0) names.insert(name);
  return names;
}

// Names that hold any of the parts.
std::set<std::string> with(const Keys& keys, const std::string& part) {
  std::set<std::string> names;
  for (const auto& [name, key] : keys)
    if (name.find(part) != std::string::npos) names.insert(name);
  return names;
}

std::set<std::string> all(const Keys& keys) { return with(keys, ""); }

std::set<std::string> chains(const Keys& keys) { return with(keys, "/"); }

TEST(Manifest, HasEveryCombinationOnceInOrder) {
  const CampaignFiles files;
  const Manifest manifest = plan(files.campaign);
  EXPECT_EQ(manifest.garment_keys.size(), 2u);
  ASSERT_EQ(manifest.chains.size(), 8u);
  std::set<std::string> keys(manifest.garment_keys.begin(), manifest.garment_keys.end());
  for (int i = 0; i < 8; ++i) {
    const Chain& chain = manifest.chains[i];
    EXPECT_EQ(chain.motion, i / 4);
    EXPECT_EQ(chain.design, i / 2 % 2);
    EXPECT_EQ(chain.shape, i % 2);
    keys.insert(chain.key);
  }
  EXPECT_EQ(keys.size(), 10u);
  for (const std::string& key : keys) EXPECT_THAT(key, testing::MatchesRegex("[0-9a-f]+"));
}

TEST(Manifest, KeysFollowContentNotPlace) {
  const CampaignFiles here, there;
  EXPECT_NE(here.campaign.body_file, there.campaign.body_file);
  EXPECT_EQ(keys_of(here.campaign), keys_of(there.campaign));
  EXPECT_EQ(keys_of(here.campaign), keys_of(here.campaign));
}

TEST(Manifest, KeysChangeWithWhatTheyDependOnAndNothingElse) {
  const CampaignFiles files;
  const Campaign& base = files.campaign;
  const Keys keys = keys_of(base);
  const auto changed_by = [&](const std::function<void(Campaign&)>& change) {
    Campaign campaign = base;
    change(campaign);
    return changed(keys, keys_of(campaign));
  };
  EXPECT_EQ(changed_by([](Campaign& c) { c.designs[0].length += 1e-15; }), with(keys, "tee"));
  EXPECT_EQ(changed_by([](Campaign& c) { c.designs[0].sleeve = 0.3; }), with(keys, "tee"));
  EXPECT_EQ(changed_by([](Campaign& c) { c.designs[1].cleavage = 0.3; }), with(keys, "dress"));
  EXPECT_EQ(changed_by([](Campaign& c) { std::swap(c.designs[0].length, c.designs[1].length); }),
            all(keys));
  EXPECT_EQ(changed_by([](Campaign& c) { c.shapes[1][1] = -0.5; }), with(keys, "/1"));
  EXPECT_EQ(changed_by([](Campaign& c) { c.shapes[1].conservativeResize(1); }), with(keys, "/1"));
  EXPECT_EQ(changed_by([](Campaign& c) { c.motions[0].settings += "start_s: 1\n"; }),
            with(keys, "walk/"));
  EXPECT_EQ(changed_by([](Campaign& c) { c.settings += "step_m: 1\n"; }), all(keys));
  EXPECT_EQ(changed_by([](Campaign& c) { c.fabric.friction = 0.41; }), all(keys));
  EXPECT_EQ(changed_by([](Campaign& c) { c.fabric.membrane = "neo_hookean"; }), all(keys));
  EXPECT_EQ(changed_by([](Campaign& c) {
              c.fabric.tables = garment::FabricTables{};
              c.fabric.tables->bending[2][4] = 1e-5;
            }),
            all(keys));
  // A range around what was: garments settle in its middle, and each chain draws its own.
  EXPECT_EQ(changed_by([](Campaign& c) {
              c.fabric.friction = garment::Range(0.3, 2 * garment::Fabric{}.friction - 0.3);
            }),
            chains(keys));
  EXPECT_EQ(changed_by([](Campaign& c) { c.garment_vertices = 1200; }), all(keys));
  // Neither who is trained on, nor where files lie, nor the order of the lists, nor a seed that
  // nothing is drawn from.
  EXPECT_EQ(changed_by([](Campaign& c) { c.seed = 9; }), std::set<std::string>{});
  EXPECT_EQ(changed_by([](Campaign& c) { c.fabric.file = "elsewhere.json"; }),
            std::set<std::string>{});
  EXPECT_EQ(changed_by([](Campaign& c) { c.designs[0].is_held_out = true; }),
            std::set<std::string>{});
  EXPECT_EQ(changed_by([](Campaign& c) { std::reverse(c.designs.begin(), c.designs.end()); }),
            std::set<std::string>{});
  EXPECT_EQ(changed_by([](Campaign& c) { std::reverse(c.motions.begin(), c.motions.end()); }),
            std::set<std::string>{});
}

TEST(Manifest, DrawsAFabricForEachChain) {
  const CampaignFiles files;
  Campaign campaign = files.campaign;
  campaign.fabric.density_kg_per_m2 = garment::Range(0.1, 0.3);
  const Manifest manifest = plan(campaign);
  std::set<double> densities;
  for (const Chain& chain : manifest.chains)
    densities.insert(fabric_of(campaign, chain).density_kg_per_m2);
  EXPECT_EQ(densities.size(), manifest.chains.size());
  EXPECT_GE(*densities.begin(), 0.1);
  EXPECT_LT(*densities.rbegin(), 0.3);
  const Keys keys = keys_of(campaign);
  EXPECT_EQ(keys_of(campaign), keys);
  campaign.seed = 9;
  EXPECT_EQ(changed(keys, keys_of(campaign)), chains(keys));
}

TEST(Manifest, MoreOfAnythingLeavesOtherKeysAsTheyWere) {
  CampaignFiles files;
  files.campaign.fabric.friction = garment::Range(0.2, 0.5);
  const Keys keys = keys_of(files.campaign);
  Campaign more = files.campaign;
  more.designs.insert(more.designs.begin(), {"tunic", 0.6, 0.5, 0.2, false});
  more.shapes.push_back(Eigen::VectorXd::Constant(1, -1));
  more.motions.insert(more.motions.begin(), {"run", files.campaign.motions[0].file, {}, ""});
  const Keys after = keys_of(more);
  EXPECT_EQ(after.size(), 3u + 27u);
  for (const auto& [name, key] : keys) EXPECT_EQ(after.at(name), key) << name;
}

TEST(Manifest, KeysFollowTheContentOfFiles) {
  const CampaignFiles files;
  const Keys keys = keys_of(files.campaign);
  write_swing(files.campaign.motions[1].file, 0.3);
  const Keys moved = keys_of(files.campaign);
  EXPECT_EQ(changed(keys, moved), with(keys, "jump/"));
  body::BodyModel body = body::box_body();
  body.template_vertices *= 1.01;
  body::write_body(files.campaign.body_file, body);
  EXPECT_EQ(changed(moved, keys_of(files.campaign)), all(keys));
}

// A list of numbers must not read the same as another one: 1, 12 and 11, 2.
TEST(Manifest, KeysTellListsApart) {
  const CampaignFiles files;
  Campaign campaign = files.campaign;
  campaign.shapes = {Vec<2>(1, 12), Vec<2>(11, 2), Vec<1>(112), Vec<3>(1, 1, 2)};
  const Keys keys = keys_of(campaign);
  std::set<std::string> different;
  for (const std::string& name : chains(keys)) different.insert(keys.at(name));
  EXPECT_EQ(different.size(), 16u);
}

TEST(Manifest, RefusesAShapeGivenTwice) {
  CampaignFiles files;
  files.campaign.shapes.push_back(files.campaign.shapes[1]);
  EXPECT_INPUT_ERROR(plan(files.campaign), "shapes", "twice");
}

TEST(Manifest, RefusesNamesGivenTwiceAndMissingFiles) {
  const CampaignFiles files;
  Campaign campaign = files.campaign;
  campaign.designs[1].name = "tee";
  EXPECT_INPUT_ERROR(plan(campaign), "designs", "'tee'", "twice");
  campaign = files.campaign;
  campaign.motions[1].name = "walk";
  EXPECT_INPUT_ERROR(plan(campaign), "motions", "'walk'", "twice");
  campaign = files.campaign;
  campaign.motions[1].file = files.scratch.path("absent.npz");
  EXPECT_INPUT_ERROR(plan(campaign), "absent.npz");
  campaign = files.campaign;
  campaign.body_file = files.scratch.path("nobody.npz");
  EXPECT_INPUT_ERROR(plan(campaign), "nobody.npz");
}

TEST(Manifest, IsWrittenWithNamesAndKeys) {
  CampaignFiles files;
  files.campaign.designs[1].is_held_out = true;
  files.campaign.motions[0].name = "walk \"A\"\n";
  const Manifest manifest = plan(files.campaign);
  write_manifest(files.scratch.path(""), files.campaign, manifest);
  std::ifstream stream(files.scratch.path("manifest.jsonl"));
  std::vector<nlohmann::json> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(nlohmann::json::parse(line));
  ASSERT_EQ(lines.size(), 1 + manifest.chains.size());
  ASSERT_EQ(lines[0]["designs"].size(), 2u);
  const nlohmann::json& dress = lines[0]["designs"][1];
  EXPECT_EQ(dress["name"], "dress");
  EXPECT_EQ(dress["length"], 0.9);
  EXPECT_EQ(dress["sleeve"], 0.5);
  EXPECT_EQ(dress["cleavage"], 0.4);
  EXPECT_EQ(dress["held_out"], true);
  EXPECT_EQ(dress["garment"], manifest.garment_keys[1]);
  const nlohmann::json& chain = lines[4];
  EXPECT_EQ(chain["key"], manifest.chains[3].key);
  EXPECT_EQ(chain["motion"], "walk \"A\"\n");
  EXPECT_EQ(chain["design"], "dress");
  EXPECT_EQ(chain["shape"], nlohmann::json({0.5, 0.5}));
  EXPECT_EQ(lines[3]["shape"], nlohmann::json::array());
}

TEST(Manifest, IsReadAsItWasWritten) {
  CampaignFiles files;
  files.campaign.profile = "portable";
  const Manifest manifest = plan(files.campaign);
  const std::string folder = files.scratch.path("");
  write_manifest(folder, files.campaign, manifest);
  const ManifestFile again = read_manifest(folder);
  EXPECT_EQ(again.profile, "portable");
  EXPECT_EQ(again.garment_keys, manifest.garment_keys);
  ASSERT_EQ(again.chains.size(), 8u);
  EXPECT_EQ(again.chains[3].key, manifest.chains[3].key);
  EXPECT_EQ(again.chains[3].garment_key, manifest.garment_keys[1]);
  EXPECT_EQ(again.chains[3].motion, "walk");
  EXPECT_EQ(again.chains[3].design, "dress");
  EXPECT_EQ(again.chains[3].shape, (std::vector<double>{0.5, 0.5}));
}

TEST(Manifest, RefusesFilesThatAreNone) {
  const CampaignFiles files;
  const std::string folder = files.scratch.path(""), path = files.scratch.path("manifest.jsonl");
  EXPECT_INPUT_ERROR(read_manifest(folder), "manifest.jsonl", "folder of a campaign");
  write_bytes(path, "");
  EXPECT_INPUT_ERROR(read_manifest(folder), "empty");
  write_bytes(path, "{\"designs\": []}\n");
  EXPECT_INPUT_ERROR(read_manifest(folder), "manifest.jsonl:1");
  write_manifest(folder, files.campaign, plan(files.campaign));
  const std::string good = read_bytes(path);
  write_bytes(path, good.substr(0, good.size() - 30));
  EXPECT_INPUT_ERROR(read_manifest(folder), "manifest.jsonl:9");
  write_bytes(path, good.substr(0, good.rfind('\n', good.size() - 2) + 1));  // at the end of a line
  EXPECT_INPUT_ERROR(read_manifest(folder), "7 of 8 chains");
  // A key is part of paths.
  write_bytes(
      path, good.substr(0, good.find('\n') + 1) +
                R"({"key":"../../elsewhere.","garment":"a","motion":"m","design":"d","shape":[]})");
  EXPECT_INPUT_ERROR(read_manifest(folder), "manifest.jsonl:2", "hexadecimal");
}

}  // namespace
}  // namespace pleat::campaign
