// The stages up to the dataset, on drapes made by hand: what is done stays done, and what changes
// takes effect.
#include "app/pipeline.h"

#include <gmock/gmock.h>

#include "app/yaml_reader.h"
#include "body/amass_file.h"
#include "body/body_file.h"
#include "campaign/run_tasks.h"
#include "encode/dataset.h"
#include "garment/garment_file.h"
#include "tests/core/input_error.h"
#include "tests/core/scratch.h"
#include "tests/encode/synthetic_body.h"

namespace pleat::app {
namespace {

// Two designs of the tube through two motions, settled and simulated already.
struct Simulated {
  Scratch scratch;
  encode::Tube tube = encode::make_tube(10, 20);
  body::BodyModel model = encode::column_body();
  std::string text;
  int accepted = 4;  // frames of 4 a clip

  explicit Simulated(int accepted_frames = 4) : accepted(accepted_frames) {
    body::write_body(scratch.path("body.npz"), model);
    for (const std::string name : {"walk", "jump"}) {
      body::Motion motion{name, 30, {}};
      for (int t = 0; t < 4; ++t) motion.frames.push_back(encode::spine_pose(0.1 * t));
      body::write_amass(scratch.path(name + ".npz"), motion, Vec<3>::Zero());
    }
    text = "output: " + scratch.path("out") + "\nbody: {file: " + scratch.path("body.npz") +
           "}\nmotions: [{file: " + scratch.path("walk.npz") +
           "}, {file: " + scratch.path("jump.npz") +
           "}]\nshapes: [[0.5, -1]]\nencode: {texture_size: 64}\n";
    const StudyConfig study = read("false");
    const campaign::Campaign campaign = campaign_of(study);
    const campaign::Manifest manifest = campaign::plan(campaign);
    std::filesystem::create_directories(study.output + "/garments");
    std::filesystem::create_directories(study.output + "/shards");
    for (size_t d = 0; d < study.designs.size(); ++d)
      garment::write_garment(campaign::garment_path(study.output, manifest.garment_keys[d]),
                             encode::tube_garment(tube, study.designs[d]), {});
    for (const campaign::Chain& chain : manifest.chains) {
      const garment::Garment garment = encode::tube_garment(tube, study.designs[chain.design]);
      garment::Clip clip =
          encode::tube_clip(tube, garment, model, campaign.motions[chain.motion].name, 4);
      for (int t = accepted; t < 4; ++t) {
        clip.certificates[t].is_accepted = false;
        clip.certificates[t].reason = "not settled";
      }
      garment::write_clip(campaign::shard_path(study.output, chain.key), clip, chain.key, {});
    }
  }

  StudyConfig read(const std::string& dress_is_held_out) const {
    write_bytes(scratch.path("study.yaml"),
                text + "designs: [{name: tee}, {name: dress, length: 0.9, held_out: " +
                    dress_is_held_out + "}]\n");
    return read_study(scratch.path("study.yaml"));
  }
  std::string out(const std::string& name) const { return scratch.path("out/" + name); }
};

std::array<int, encode::kSplits> split_counts(const std::string& path) {
  std::array<int, encode::kSplits> counts = {};
  const encode::Dataset dataset(path);
  for (const encode::DatasetRow& row : dataset.contents().rows) ++counts[row.split];
  return counts;
}

TEST(Pipeline, EncodesWhatWasSimulatedOnce) {
  const Simulated simulated;
  const StudyConfig study = simulated.read("false");
  ASSERT_TRUE(run_stages(study, Stage::kEncode));
  EXPECT_THAT(split_counts(simulated.out("dataset.h5")), testing::ElementsAre(16, 0, 0, 0));
  EXPECT_EQ(read_bytes(simulated.out("config.yaml")), to_yaml(study));
  EXPECT_EQ(to_yaml(read_study(simulated.out("config.yaml"))), to_yaml(study));
  for (const std::string name :
       {"manifest.jsonl", "stages/dress.json", "stages/simulate.json", "stages/encode.json"})
    EXPECT_TRUE(std::filesystem::exists(simulated.out(name))) << name;

  const auto written = std::filesystem::last_write_time(simulated.out("dataset.h5"));
  ASSERT_TRUE(run_stages(study, Stage::kEncode));
  EXPECT_EQ(std::filesystem::last_write_time(simulated.out("dataset.h5")), written);
  std::filesystem::remove(simulated.out("dataset.h5"));
  ASSERT_TRUE(run_stages(study, Stage::kEncode));
  EXPECT_TRUE(std::filesystem::exists(simulated.out("dataset.h5")));
}

// Who is held out is asked when encoding: drapes do not depend on it, and are not made again.
TEST(Pipeline, HoldingOutADesignLaterTakesEffect) {
  const Simulated simulated;
  ASSERT_TRUE(run_stages(simulated.read("false"), Stage::kEncode));
  ASSERT_TRUE(run_stages(simulated.read("true"), Stage::kEncode));
  EXPECT_THAT(split_counts(simulated.out("dataset.h5")), testing::ElementsAre(8, 8, 0, 0));
  ASSERT_TRUE(run_stages(simulated.read("false"), Stage::kEncode));
  EXPECT_THAT(split_counts(simulated.out("dataset.h5")), testing::ElementsAre(16, 0, 0, 0));
}

TEST(Pipeline, RefusesADatasetWithoutAcceptedFrames) {
  const Simulated simulated(0);
  EXPECT_INPUT_ERROR(run_stages(simulated.read("false"), Stage::kEncode),
                     "none of the 16 frames was accepted");
  EXPECT_FALSE(std::filesystem::exists(simulated.out("dataset.h5")));
  EXPECT_FALSE(std::filesystem::exists(simulated.out("stages/encode.json")));
}

TEST(Pipeline, LeavesOutRejectedFrames) {
  const Simulated simulated(3);
  ASSERT_TRUE(run_stages(simulated.read("true"), Stage::kEncode));
  EXPECT_THAT(split_counts(simulated.out("dataset.h5")), testing::ElementsAre(6, 6, 0, 0));
}

TEST(Pipeline, RefusesAnOutputThatIsAFile) {
  const Simulated simulated;
  StudyConfig study = simulated.read("false");
  study.output = simulated.scratch.path("body.npz");
  EXPECT_INPUT_ERROR(run_stages(study, Stage::kDress), "output", study.output);
}

}  // namespace
}  // namespace pleat::app
