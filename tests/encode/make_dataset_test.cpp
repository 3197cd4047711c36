#include "encode/make_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "body/body_file.h"
#include "core/error.h"
#include "garment/clip.h"
#include "garment/garment_file.h"
#include "tests/encode/synthetic_body.h"

namespace pleat::encode {
namespace {

using testing::HasSubstr;

// Two designs, one held out, each through a walk and a jump of five frames; frame 2 of the tee's
// walk was not accepted.
struct Campaign {
  TemporaryFolder folder;
  Tube tube = make_tube(10, 20);
  body::BodyModel model = column_body();
  DatasetInputs inputs;
  EncodeConfig config;

  Campaign() {
    config.texture_size = 64;
    config.held_out_motions = {"jump"};
    inputs.body_file = folder / "body.npz";
    body::write_body(inputs.body_file, model);
    for (const garment::Design& design : {garment::Design{"tee", 0.3, 0.25, 0.2, false},
                                          garment::Design{"dress", 0.9, 0.5, 0.4, true}}) {
      const garment::Garment garment = tube_garment(tube, design);
      inputs.garment_files.push_back(folder / (design.name + ".h5"));
      garment::write_garment(inputs.garment_files.back(), garment, {});
      for (const std::string& motion : std::vector<std::string>{"walk", "jump"}) {
        garment::Clip clip = tube_clip(tube, garment, model, motion, 5);
        if (design.name == "tee" && motion == "walk") reject(clip, 2);
        inputs.clip_files.push_back(folder / (design.name + "_" + motion + ".h5"));
        garment::write_clip(inputs.clip_files.back(), clip, design.name + "/" + motion, {});
      }
    }
  }

  static void reject(garment::Clip& clip, size_t frame) {
    clip.certificates[frame].is_accepted = false;
    clip.certificates[frame].reason = "too much strain";
  }

  DatasetReport make() {
    return make_dataset(inputs, config, {"encode", "encode:\n", 1, {}}, folder / "dataset.h5");
  }

  std::string message() {
    try {
      make();
    } catch (const InputError& error) {
      EXPECT_FALSE(std::filesystem::exists(folder / "dataset.h5"));
      return error.what();
    }
    return "";
  }
};

TEST(MakeDataset, KeepsAcceptedFramesWithTheirSplitsAndLinks) {
  Campaign campaign;
  const DatasetReport report = campaign.make();
  EXPECT_EQ(report.accepted_frames, 19);
  EXPECT_EQ(report.rejected_frames, 1);
  EXPECT_THAT(report.split_frames, testing::ElementsAre(4, 5, 5, 5));

  const Dataset dataset(campaign.folder / "dataset.h5");
  ASSERT_EQ(dataset.row_count(), 19);
  const std::vector<int> frames = {0, 1, 3, 4}, previous = {-1, 0, -1, 2};
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(dataset.row(i).frame, frames[static_cast<size_t>(i)]);
    EXPECT_EQ(dataset.row(i).previous, previous[static_cast<size_t>(i)]);
    EXPECT_EQ(dataset.row(i).split, kTrain);
    EXPECT_EQ(dataset.row(i).clip_key, "tee/walk");
  }
  EXPECT_EQ(dataset.row(4).previous, -1);  // another clip begins
  EXPECT_EQ(dataset.row(4).split, kHeldOutSequence);
  EXPECT_EQ(dataset.row(9).split, kHeldOutDesign);
  EXPECT_EQ(dataset.row(18).split, kHeldOutBoth);
  EXPECT_EQ(dataset.row(18).previous, 17);
  EXPECT_EQ(dataset.garment(18).design.name, "dress");
  EXPECT_FALSE(dataset.contents().sequences[0].is_held_out);
  EXPECT_TRUE(dataset.contents().sequences[1].is_held_out);
  EXPECT_EQ(dataset.row(0).shape, Vec<2>(0.5, -1));
}

TEST(MakeDataset, RoundTripIsAsCloseAsItReports) {
  Campaign campaign;
  const DatasetReport report = campaign.make();
  EXPECT_GT(report.round_trip_mean_mm, 0);
  EXPECT_LT(report.round_trip_mean_mm, 0.1);
  EXPECT_LE(report.round_trip_mean_mm, report.round_trip_p99_mm);
  EXPECT_LE(report.round_trip_p99_mm, report.round_trip_max_mm);
  EXPECT_GT(report.smallest_singular_value, 0.5);

  const Dataset dataset(campaign.folder / "dataset.h5");
  const body::BodyModel model = read_body_of(dataset, campaign.inputs.body_file);
  const garment::Clip walk = garment::read_clip(campaign.inputs.clip_files[0]);
  double worst = 0;
  for (int row = 0; row < 4; ++row) {
    const Points3 decoded = decode_posed(dataset, row, dataset.texture(row), model);
    const Points3& simulated = walk.positions[static_cast<size_t>(dataset.row(row).frame)];
    worst = std::max(worst, 1000 * (decoded - simulated).rowwise().norm().maxCoeff());
  }
  // Body, pose, template and weights pass through float32, which costs less than 1 micrometre.
  EXPECT_LE(worst, report.round_trip_max_mm + 1e-3);
}

TEST(MakeDataset, FixedPointUsesItsRangeAndClipsNothing) {
  Campaign campaign;
  const DatasetReport fixed = campaign.make();
  EXPECT_GT(fixed.scale_m * 32767, fixed.largest_offset_m);
  EXPECT_LT(fixed.scale_m * 32767, 1.01 * fixed.largest_offset_m);
  const Dataset in_int16(campaign.folder / "dataset.h5");
  std::vector<Texture> textures;
  for (int64_t row = 0; row < in_int16.row_count(); ++row)
    textures.push_back(in_int16.texture(row));

  campaign.config.dtype = "float32";
  EXPECT_EQ(campaign.make().scale_m, 0);
  const Dataset in_float(campaign.folder / "dataset.h5");
  for (int64_t row = 0; row < in_float.row_count(); ++row) {
    const Texture exact = in_float.texture(row);
    for (size_t i = 0; i < exact.values.size(); ++i) {
      ASSERT_NEAR(textures[static_cast<size_t>(row)].values[i], exact.values[i],
                  0.5 * fixed.scale_m + 4e-9);
    }
  }
}

TEST(MakeDataset, NormalisationIsThatOfTheTrainingSplit) {
  Campaign campaign;
  campaign.config.dtype = "float32";
  campaign.make();
  const Dataset dataset(campaign.folder / "dataset.h5");
  OffsetSums sums;
  for (int64_t row = 0; row < 4; ++row) add(sums, dataset.texture(row), dataset.contents().mask);
  const Normalisation expected = normalisation(sums);
  EXPECT_LT((dataset.contents().normalisation.mean - expected.mean).norm(), 1e-8);
  EXPECT_LT((dataset.contents().normalisation.std - expected.std).norm(), 1e-8);
}

TEST(MakeDataset, GivesTheSameBytesAgain) {
  Campaign campaign;
  campaign.make();
  const std::string first = sha256_of_file(campaign.folder / "dataset.h5");
  campaign.make();
  EXPECT_EQ(sha256_of_file(campaign.folder / "dataset.h5"), first);
}

TEST(MakeDataset, FitIsCloserThanTheBarycentricFill) {
  Campaign campaign;
  const double fitted = campaign.make().round_trip_mean_mm;
  campaign.config.fill = "barycentric";
  EXPECT_LT(fitted, 0.3 * campaign.make().round_trip_mean_mm);
}

TEST(MakeDataset, RefusesAnEmptyDataset) {
  Campaign campaign;
  const std::vector<std::string> clips = campaign.inputs.clip_files;
  campaign.inputs.clip_files.clear();
  EXPECT_THAT(campaign.message(), HasSubstr("no clip"));

  campaign.inputs.clip_files = {clips[1]};
  EXPECT_THAT(campaign.message(), HasSubstr("no frame is left to train on"));

  garment::Clip clip = garment::read_clip(clips[0]);
  for (size_t t = 0; t < clip.certificates.size(); ++t) Campaign::reject(clip, t);
  garment::write_clip(clips[0], clip, "rejected", {});
  campaign.inputs.clip_files = {clips[0]};
  campaign.config.held_out_motions.clear();
  EXPECT_THAT(campaign.message(), HasSubstr("none of the 5 frames was accepted"));

  campaign.inputs.garment_files.clear();
  EXPECT_THAT(campaign.message(), HasSubstr("no garment"));
}

TEST(MakeDataset, RefusesInputsThatDoNotBelongTogether) {
  {
    Campaign campaign;
    campaign.config.held_out_motions = {"jmup"};
    EXPECT_THAT(campaign.message(), testing::AllOf(HasSubstr("jmup"), HasSubstr("walk, jump")));
  }
  {
    Campaign campaign;
    campaign.inputs.garment_files.pop_back();
    EXPECT_THAT(campaign.message(), HasSubstr("dress"));
  }
  {
    Campaign campaign;
    campaign.inputs.clip_files.push_back(campaign.inputs.clip_files.front());
    EXPECT_THAT(campaign.message(), HasSubstr("twice"));
  }
  {
    Campaign campaign;
    const Tube finer = make_tube(11, 20);
    garment::write_garment(campaign.inputs.garment_files[1],
                           tube_garment(finer, {"dress", 0.9, 0.5, 0.4, true}), {});
    EXPECT_THAT(campaign.message(), HasSubstr("another topology"));
  }
}

TEST(MakeDataset, ConfigNamesTheWrongKey) {
  const auto message = [](const auto& change) -> std::string {
    EncodeConfig config;
    change(config);
    try {
      validate(config);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message([](EncodeConfig&) {}), "");
  EXPECT_THAT(message([](EncodeConfig& c) { c.texture_size = 32; }),
              HasSubstr("encode.texture_size"));
  EXPECT_THAT(message([](EncodeConfig& c) { c.fill = "x"; }), HasSubstr("encode.fill"));
  EXPECT_THAT(message([](EncodeConfig& c) { c.dtype = "x"; }), HasSubstr("encode.dtype"));
  EXPECT_THAT(message([](EncodeConfig& c) { c.skinning = "x"; }), HasSubstr("encode.skinning"));
  EXPECT_THAT(message([](EncodeConfig& c) { c.gzip_level = 10; }), HasSubstr("encode.gzip_level"));
}

}  // namespace
}  // namespace pleat::encode
